#include "sim/base/text_file.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <fstream>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

bool IsFollower(unsigned char byte) {
  return (byte & 0xC0) == 0x80;
}

// Bytes of the UTF-8 character that `text` (not empty) begins with; 0 if there is none
// or it is the zero byte. Overlong forms, surrogates and what lies beyond U+10FFFF are
// not characters (RFC 3629).
std::size_t Utf8Length(std::string_view text) {
  const auto at = [&](std::size_t i) -> unsigned char {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const unsigned char first = at(0);
  if (first == 0) return 0;
  if (first < 0x80) return 1;
  const unsigned char second = at(1);
  if (!IsFollower(second)) return 0;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (!IsFollower(at(2))) return 0;
  if (first == 0xE0) return second >= 0xA0 ? 3 : 0;
  if (first == 0xED) return second < 0xA0 ? 3 : 0;
  if (first > 0xE0 && first < 0xF0) return 3;
  if (!IsFollower(at(3))) return 0;
  if (first == 0xF0) return second >= 0x90 ? 4 : 0;
  if (first == 0xF4) return second < 0x90 ? 4 : 0;
  return first > 0xF0 && first < 0xF4 ? 4 : 0;
}

}  // namespace

std::string ReadTextFile(const fs::path& file, std::size_t most_bytes) {
  const Place place{.file = file.string()};
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) throw InputError(place, "there is no such file");
  if (fs::is_directory(status)) {
    throw InputError(place, "this is a folder, where a file is wanted");
  }
  const auto too_large = [&] {
    return InputError(
        {.file = file.string(), .line = 1, .column = 1},
        fmt::format("larger than any file of this kind (at most {} bytes)",
                    most_bytes));
  };
  if (fs::is_regular_file(status) && fs::file_size(file, error) > most_bytes) {
    throw too_large();
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(place, "this file cannot be read");
  std::string text;
  std::string chunk(1 << 16, '\0');
  while (in && text.size() <= most_bytes) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    text.append(chunk, 0, static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) throw InputError(place, "this file cannot be read");
  if (text.size() > most_bytes) throw too_large();
  return text;
}

void RequireText(const std::string& text, const std::string& name) {
  int line = 1;
  std::size_t line_start = 0;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '\n') {
      ++line;
      line_start = i + 1;
    }
    const std::size_t length = Utf8Length(std::string_view(text).substr(i));
    if (length == 0) {
      throw InputError(
          {.file = name, .line = line, .column = static_cast<int>(i - line_start) + 1},
          text[i] == '\0' ? "a zero byte: this is not a text file"
                          : "this is not UTF-8 text",
          text[i] == '\0' ? "" : "save the file as UTF-8");
    }
    i += length;
  }
}

std::string Printable(std::string_view text) {
  std::string printable;
  while (!text.empty()) {
    const std::size_t length = Utf8Length(text);
    const auto code = static_cast<unsigned char>(text.front());
    const bool is_control = (code < 0x20 && code != '\t') || code == 0x7f;
    if (length == 0 || is_control) {
      printable += fmt::format("\\x{:02x}", code);
      text.remove_prefix(1);
    } else {
      printable += text.substr(0, length);
      text.remove_prefix(length);
    }
  }
  return printable;
}

namespace {

fs::path PartOf(const fs::path& file) {
  return {file.string() + fmt::format(".{}.part", ::getpid())};
}

// What writers of the file left beside it that were killed.
void RemoveOldParts(const fs::path& folder, const std::string& name) {
  constexpr std::string_view kEnd = ".part";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string part = entry.path().filename().string();
    if (!part.starts_with(name + ".") || !part.ends_with(kEnd)) continue;
    const char* const digits = part.data() + name.size() + 1;
    const char* const end = part.data() + part.size() - kEnd.size();
    int writer = 0;
    const bool is_part =
        digits < end && std::from_chars(digits, end, writer).ptr == end && writer > 0;
    const bool is_gone = is_part && kill(writer, 0) != 0 && errno == ESRCH;
    std::error_code ignored;
    if (is_gone) fs::remove(entry.path(), ignored);
  }
}

}  // namespace

void WriteTextFile(const fs::path& file, const std::string& text) {
  const Place place{.file = file.string()};
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  const fs::file_status status = fs::status(file, error);
  const bool in_place = fs::exists(status) && !fs::is_regular_file(status);
  const fs::path beside = in_place ? file : PartOf(file);
  std::ofstream out(beside, std::ios::binary);
  out << text;
  out.close();
  const bool is_written = static_cast<bool>(out);
  if (in_place && is_written) return;
  if (is_written) fs::rename(beside, file, error);
  if (!is_written || error) {
    if (!in_place) fs::remove(beside, error);
    throw InputError(place, "this file cannot be written");
  }
}

void WriteDurably(const fs::path& file, const std::string& text) {
  const Place place{.file = file.string()};
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  fs::create_directories(folder, error);
  RemoveOldParts(folder, file.filename().string());
  const fs::path beside = PartOf(file);
  const int out =
      open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR);
  std::string_view left = text;
  while (out >= 0 && !left.empty()) {
    const ssize_t count = write(out, left.data(), left.size());
    if (count <= 0) break;
    left.remove_prefix(static_cast<std::size_t>(count));
  }
  bool is_written = out >= 0 && left.empty() && fsync(out) == 0;
  if (out >= 0) is_written = close(out) == 0 && is_written;
  if (is_written) fs::rename(beside, file, error);
  if (!is_written || error) {
    fs::remove(beside, error);
    throw InputError(place, "this file cannot be written");
  }
  // The new name too has to be on the disk.
  const int entry = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (entry >= 0) {
    fsync(entry);
    close(entry);
  }
}

}  // namespace caltwin
