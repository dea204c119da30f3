#include "scenarios/study/trials_csv.h"

#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

// A name as a cell of a CSV file (RFC 4180).
std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  }
  return quoted + "\"";
}

std::string Cell(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

std::string LineOf(const Study& study,
                   const TrialResult& result,
                   const std::set<std::string>& names) {
  std::string line = fmt::format("{},{},{},{},{}",
                                 result.trial,
                                 study.seed,
                                 result.status,
                                 result.machine_time_s,
                                 result.touches);
  std::map<std::string_view, const ParameterResult*> by_name;
  for (const ParameterResult& parameter : result.parameters) {
    by_name[parameter.name] = &parameter;
  }
  for (const std::string& name : names) {
    const auto found = by_name.find(name);
    if (found == by_name.end()) {
      line += ",,,";
      continue;
    }
    const ParameterResult& parameter = *found->second;
    line += fmt::format(
        ",{},{},{}", parameter.injected, Cell(parameter.recovered), Cell(parameter.sd));
  }
  if (study.cases.size() > 1) line += "," + Quoted(study.cases[result.of_case].Name());
  return line + "\n";
}

void EachLine(const Study& study,
              const StudyStore& store,
              const std::function<void(std::string_view)>& write) {
  std::set<std::string> names;
  store.ForEach([&](const TrialResult& result) {
    for (const ParameterResult& parameter : result.parameters) {
      names.insert(parameter.name);
    }
  });
  std::string head = "trial,seed,status,machine_time_s,touches";
  for (const std::string& name : names) {
    head += fmt::format(",{0}.injected,{0}.recovered,{0}.sd", name);
  }
  write(head + (study.cases.size() > 1 ? ",case\n" : "\n"));
  store.ForEach(
      [&](const TrialResult& result) { write(LineOf(study, result, names)); });
}

// Whether the file says so already: then it is left alone, its time of writing too.
bool IsWritten(const Study& study, const StudyStore& store, const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  bool is_same = in.good();
  std::string there;
  EachLine(study, store, [&](std::string_view line) {
    if (!is_same) return;
    there.resize(line.size());
    is_same = in.read(there.data(), static_cast<std::streamsize>(line.size())) &&
              there == line;
  });
  return is_same && in.peek() == std::ifstream::traits_type::eof();
}

}  // namespace

std::string TrialsCsv(const Study& study, const StudyStore& store) {
  std::string csv;
  EachLine(study, store, [&](std::string_view line) { csv += line; });
  return csv;
}

void WriteTrialsCsv(const Study& study, const StudyStore& store, const fs::path& file) {
  if (IsWritten(study, store, file)) return;
  const fs::path beside = file.string() + ".part";
  std::error_code error;
  std::ofstream out(beside, std::ios::binary);
  EachLine(study, store, [&](std::string_view line) { out << line; });
  out.close();
  if (out) fs::rename(beside, file, error);
  if (out && !error) return;
  fs::remove(beside, error);
  throw InputError({.file = file.string()},
                   "this file cannot be written; the trials are kept",
                   "make room, then `--resume`");
}

}  // namespace caltwin
