#include "tools/commands/spare_files.h"

#include <system_error>

#include <fmt/format.h>

#include "scenarios/machine_file.h"
#include "sim/base/input_error.h"
#include "sim/base/yaml.h"
#include "sim/machine/kinds/motor_stage/drawing.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

bool IsNone(const NamedFile& one) {
  return one.file.empty() || one.file == "-";
}

void RefuseRead(const NamedFile& out, const std::vector<NamedFile>& read) {
  for (const NamedFile& in : read) {
    if (IsNone(in) || !IsSameFile(out.file, in.file)) continue;
    throw InputError({.file = out.what},
                     fmt::format("'{}' is {}, which is read: it would be written over",
                                 out.file.string(),
                                 in.what),
                     "give another name");
  }
}

void RefuseTwice(const NamedFile& out, const NamedFile& other) {
  if (!IsSameFile(out.file, other.file)) return;
  throw InputError(
      {.file = out.what},
      fmt::format("'{}' is what {} writes too", out.file.string(), other.what),
      "give another name");
}

void RefuseFile(const NamedFile& out) {
  std::error_code error;
  const fs::file_status status = fs::status(out.file, error);
  if (!out.is_folder || !fs::exists(status) || fs::is_directory(status)) return;
  throw InputError(
      {.file = out.what},
      fmt::format("'{}' is a file, where a folder is wanted", out.file.string()),
      "give another name");
}

}  // namespace

bool IsSameFile(const fs::path& one, const fs::path& other) {
  std::error_code error;
  const bool is_there = fs::exists(one, error), other_is = fs::exists(other, error);
  if (is_there != other_is) return false;
  if (is_there) return !fs::is_other(one, error) && fs::equivalent(one, other, error);
  const auto plain = [&](const fs::path& file) {
    return fs::weakly_canonical(fs::absolute(file, error), error);
  };
  return plain(one) == plain(other);
}

void RefuseOverwriting(const std::vector<NamedFile>& read,
                       std::vector<NamedFile> written) {
  std::erase_if(written, IsNone);
  for (std::size_t i = 0; i < written.size(); ++i) {
    const NamedFile out = written[i];
    if (out.is_folder) written.push_back({out.what, out.file / "index.html"});
    RefuseRead(out, read);
    for (std::size_t j = 0; j < i; ++j) RefuseTwice(out, written[j]);
    RefuseFile(out);
  }
}

std::vector<NamedFile> RowsAndHeader(const std::string& what, const fs::path& rows) {
  if (rows.empty()) return {};
  const fs::path header = fs::path(rows).replace_extension(".yaml");
  if (header == rows) return {{what, rows}};
  return {{what, rows}, {what + " (the header)", header}};
}

std::vector<NamedFile> FilesOf(const Machine& machine) {
  std::vector<NamedFile> files = {{"the model of the machine", machine.model}};
  fs::path file = machine.file;
  while (!file.empty()) {
    files.push_back({"the machine file", file});
    Faults faults;
    const auto base = ReadYamlFile(file, &faults).Optional("extends");
    file = base ? FindMachine(base->Text(), file.parent_path(), base->place())
                : fs::path();
  }
  return files;
}

std::vector<NamedFile> MachineFiles(const std::string& name_or_path) {
  if (name_or_path.empty()) return {};
  const fs::path file = FindMachine(name_or_path, "", {.file = "--machine"});
  return FilesOf(ReadAnyMachineFile(file).machine);
}

std::vector<NamedFile> LinkFiles(const std::string& url) {
  constexpr std::string_view kTranscript = "transcript:";
  if (url.starts_with(kTranscript)) {
    const std::string file = url.substr(kTranscript.size());
    return {{"the transcript", file.substr(0, file.find('?'))}};
  }
  if (!url.starts_with("twin:")) return {};
  const TwinOptions twin = TwinOptionsOf(url);
  std::vector<NamedFile> files = MachineFiles(twin.machine);
  files.push_back({"the truth", twin.truth});
  return files;
}

std::vector<NamedFile> Together(const std::vector<std::vector<NamedFile>>& lists) {
  std::vector<NamedFile> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace caltwin
