#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/machine/machine.h"

namespace caltwin {

/// A file that a command reads or writes, and what a person calls it.
struct NamedFile {
  std::string what{};  ///< "the machine file"; of what is written, "--extend".
  std::filesystem::path file{};  ///< Empty, or "-": none.
  bool is_folder = false;        ///< A report's: it will hold an index.html.
};

/// Whether both names lead to one file, over symbolic links, hard links and `./`; also
/// where it is not there yet. What is no plain file (/dev/null) is never the same.
bool IsSameFile(const std::filesystem::path& one, const std::filesystem::path& other);

/// Throws InputError where something that is to be written is read too, or is written
/// twice, or is a folder where a file stands. To be called before any work.
void RefuseOverwriting(const std::vector<NamedFile>& read,
                       std::vector<NamedFile> written);

/// The rows and the header beside them (DATA.csv, DATA.yaml), "the rows" being `what`;
/// of rows that are written `what` is the option.
std::vector<NamedFile> RowsAndHeader(const std::string& what,
                                     const std::filesystem::path& rows);

/// The machine of this name or path as the command line says it, and every file that it
/// is made of. Empty: none.
std::vector<NamedFile> MachineFiles(const std::string& name_or_path);

/// The same of a machine that was read: its file, what that extends, and the model.
/// Empty where it was made without a file.
std::vector<NamedFile> FilesOf(const Machine& machine);

/// What `twin:M.yaml?truth=T.yaml` or `transcript:FILE` reads; nothing of other links.
std::vector<NamedFile> LinkFiles(const std::string& url);

/// All of them in one list.
std::vector<NamedFile> Together(const std::vector<std::vector<NamedFile>>& lists);

}  // namespace caltwin
