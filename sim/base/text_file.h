#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace caltwin {

/// @name The most that is read of a file: written by hand, or measured.
inline constexpr std::size_t kLargestFile_bytes = 1'000'000;
inline constexpr std::size_t kLargestData_bytes = 64'000'000;

/// The whole of a text file. Throws InputError, naming the file, where it is missing, a
/// folder, unreadable, or larger than `most_bytes` (told from its size, without
/// reading).
std::string ReadTextFile(const std::filesystem::path& file, std::size_t most_bytes);

/// Throws InputError at the first zero byte or byte that is not UTF-8: noise, a
/// picture, an archive or a text in another encoding given where a text file is wanted.
void RequireText(const std::string& text, const std::string& name);

/// `text` with \xNN for every control character but a tab, and for every byte that is
/// not UTF-8: what a terminal, a file of JSON or a page can take.
std::string Printable(std::string_view text);

/// Writes beside the final name and renames, so that a reader never sees half a file;
/// makes missing folders. What is no plain file (/dev/null, a pipe) is written in
/// place. Throws InputError where that cannot be done.
void WriteTextFile(const std::filesystem::path& file, const std::string& text);

/// The same, and on the disk when it returns: whenever the power goes, the file is
/// whole, as it was or as it is now.
void WriteDurably(const std::filesystem::path& file, const std::string& text);

}  // namespace caltwin
