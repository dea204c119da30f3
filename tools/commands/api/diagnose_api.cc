#include "tools/commands/api/diagnose_api.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "tools/commands/api/catalog_api.h"
#include "tools/commands/api/own_program.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostKept = 16;
constexpr std::array kOptions = {
    "unit", "axis", "map", "seed", "min_effect_um", "step_mm"};

// What was sent, sorted: data, what describes them, and what was said beside.
struct Form {
  std::map<std::string, std::string> files{};
  std::vector<std::string> data{};  ///< Names of files, in the order sent.
  std::string machine{};
  std::vector<std::string> options{};
};

std::string Unused(const std::map<std::string, std::string>& files, std::string name) {
  const fs::path path(name);
  for (int i = 2; files.contains(name); ++i) {
    name = fmt::format("{}-{}{}", path.stem().string(), i, path.extension().string());
  }
  return name;
}

std::string DashesFor(std::string key) {
  std::ranges::replace(key, '_', '-');
  return "--" + key;
}

// A `.yaml` beside data of the same name describes them; another may be a machine.
bool IsHeader(const Form& form, const std::string& name) {
  const fs::path path(name);
  return path.extension() == ".yaml" &&
         form.files.contains(fs::path(path).replace_extension(".csv").string());
}

bool IsMachine(const std::string& name, const std::string& text) {
  return name.ends_with(".yaml") && (text.find("kinematics:") != std::string::npos ||
                                     text.find("extends:") != std::string::npos);
}

void RequirePlain(const FormPart& part) {
  constexpr std::size_t kLongest = 1000;
  const bool has_control = std::ranges::any_of(
      part.body, [](char letter) { return static_cast<unsigned char>(letter) < 0x20; });
  if (!has_control && part.body.size() <= kLongest) return;
  throw Problem(
      422,
      fmt::format("the field '{}' is no option", part.name),
      {{.detail = "one line of at most 1000 letters", .pointer = "/" + part.name}});
}

Form FormOf(const HttpRequest& request) {
  Form form;
  std::vector<std::string> order;
  for (FormPart& part : ReadForm(request.Header("content-type"), request.body)) {
    if (part.name == "file") {
      const std::string name = Unused(form.files, SafeFileName(part.file_name));
      form.files[name] = std::move(part.body);
      order.push_back(name);
    } else if (part.name == "machine") {
      form.machine = part.body;
    } else if (std::ranges::find(kOptions, part.name) != kOptions.end()) {
      RequirePlain(part);
      if (!part.body.empty())
        form.options.push_back(DashesFor(part.name) + "=" + part.body);
    } else {
      throw Problem(422,
                    fmt::format("the form has no field '{}'", Printable(part.name)),
                    {{.detail = "it knows: file (repeated), machine, " +
                                fmt::format("{}", fmt::join(kOptions, ", "))}});
    }
  }
  for (const std::string& name : order) {
    if (IsHeader(form, name)) continue;
    const bool is_machine = order.size() > 1 && IsMachine(name, form.files[name]);
    if (is_machine && form.machine.empty()) form.machine = name;
    if (!is_machine) form.data.push_back(name);
  }
  return form;
}

// A path of the client's choice could be any file of this computer.
void RequireKnownMachine(const Form& form) {
  if (form.machine.empty() || form.files.contains(form.machine)) return;
  const std::vector<std::string> known = ModelNames();
  if (std::ranges::find(known, form.machine) != known.end()) return;
  throw Problem(
      422,
      fmt::format("there is no machine '{}'", Printable(form.machine)),
      {{.detail = "no such machine",
        .hint = fmt::format("one of {}, or send your machine file along as `file`",
                            fmt::join(known, ", ")),
        .pointer = "/machine"}});
}

// Measured rows as they are, by the columns that every table of them has.
bool HoldsRows(const std::string& text) {
  std::size_t at = 0;
  while (at < text.size() && text[at] == '#') {
    at = std::min(text.find('\n', at), text.size() - 1) + 1;
  }
  const std::string heading = text.substr(at, text.find('\n', at) - at);
  return heading.find("campaign") != std::string::npos &&
         heading.find("value_mm") != std::string::npos;
}

}  // namespace

void DiagnoseApi::AddTo(Routes* routes) {
  const auto add =
      [&](const char* method, const char* path, Handler go, std::size_t most) {
        routes->Add({.method = method,
                     .pattern = path,
                     .handler = std::move(go),
                     .pace = Route::Pace::kSlow,
                     .most_bytes = most});
      };
  add(
      "POST",
      "/api/diagnose",
      [this](const HttpRequest& r) { return Diagnose(r); },
      kMostUpload_bytes);
  add(
      "GET",
      "/api/diagnoses/{}/report",
      [this](const HttpRequest& r) { return Report(r); },
      0);
  add(
      "GET",
      "/api/diagnoses/{}/rows",
      [this](const HttpRequest& r) { return Rows(r); },
      0);
  add(
      "GET",
      "/api/diagnoses/{}/correction",
      [this](const HttpRequest& r) { return Correction(r); },
      0);
}

DiagnoseApi::Kept DiagnoseApi::Keep(Kept kept) {
  const std::lock_guard<std::mutex> lock(mutex_);
  kept.id = fmt::format("{}", ++last_);
  kept.folder = std::shared_ptr<const fs::path>(new fs::path(folder_.path() / kept.id),
                                                [](const fs::path* folder) {
                                                  std::error_code ignored;
                                                  fs::remove_all(*folder, ignored);
                                                  delete folder;
                                                });
  kept_.push_back(kept);
  if (kept_.size() > kMostKept) kept_.pop_front();
  return kept;
}

DiagnoseApi::Kept DiagnoseApi::Find(const std::string& id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = std::ranges::find(kept_, id, &Kept::id);
  if (found == kept_.end()) {
    throw Problem(
        404,
        fmt::format("there is no diagnosis {}", Printable(id)),
        {{.detail = "the last 16 are kept", .hint = "POST /api/diagnose again"}});
  }
  return *found;
}

std::string DiagnoseApi::DiagnoseOne(const Kept& kept, const std::string& file) {
  std::vector<std::string> asked = kept.words;
  asked.insert(asked.end(), {"--replay", "none", "--json", "answer.json"});
  const std::string text =
      RunOwnProgram({.words = asked, .folder = *kept.folder, .stop = stop_});
  Json tree =
      Json::parse(ReadTextFile(*kept.folder / "answer.json", kLargestData_bytes));
  tree["import"] = {{"file", file}, {"notes", tree.value("remarks", Json::array())}};
  tree["text"] = text;
  tree["id"] = kept.id;
  return JsonLine(tree);
}

HttpResponse DiagnoseApi::Diagnose(const HttpRequest& request) {
  const Form form = FormOf(request);
  if (form.data.empty() || form.data.size() > kMostKept) {
    throw Problem(422,
                  form.data.empty() ? "no data were sent" : "too many files at once",
                  {{.detail = "1 to 16 files with measured data are expected in `file`",
                    .hint = "curl -F file=@data.csv .../api/diagnose",
                    .pointer = "/file"}});
  }
  RequireKnownMachine(form);
  std::vector<std::string> answers;
  for (const std::string& file : form.data) {
    std::vector<std::string> words = {"diagnose", file};
    words.insert(words.end(), form.options.begin(), form.options.end());
    if (!form.machine.empty()) words.push_back("--machine=" + form.machine);
    const Kept kept = Keep({.words = words});
    for (const auto& [name, text] : form.files) {
      const bool is_other_data =
          name != file && std::ranges::find(form.data, name) != form.data.end();
      if (!is_other_data) WriteTextFile(*kept.folder / name, text);
    }
    answers.push_back(DiagnoseOne(kept, file));
  }
  if (answers.size() == 1) return {.body = answers.front() + "\n"};
  return {.body = fmt::format("{{\"format\":1,\"diagnoses\":[{}]}}\n",
                              fmt::join(answers, ","))};
}

HttpResponse DiagnoseApi::Report(const HttpRequest& request) {
  const Kept kept = Find(request.places[0]);
  const fs::path& folder = *kept.folder;
  std::vector<std::string> words = kept.words;
  words.insert(words.end(), {"--report", "report"});
  if (!fs::exists(folder / "report" / "index.html")) {
    RunOwnProgram({.words = words, .folder = folder, .stop = stop_});
  }
  return PageResponse(
      ReadTextFile(folder / "report" / "index.html", kLargestData_bytes));
}

HttpResponse DiagnoseApi::Rows(const HttpRequest& request) {
  const Kept kept = Find(request.places[0]);
  const fs::path& folder = *kept.folder;
  const std::string& file = kept.words[1];
  const std::string own = ReadTextFile(folder / file, kLargestData_bytes);
  if (HoldsRows(own)) return {.content_type = "text/csv; charset=utf-8", .body = own};
  if (!fs::exists(folder / "rows.out.csv")) {
    RunOwnProgram({.words = {"import", file, "--out", "rows.out.csv"},
                   .folder = folder,
                   .stop = stop_});
  }
  return {.content_type = "text/csv; charset=utf-8",
          .body = ReadTextFile(folder / "rows.out.csv", kLargestData_bytes)};
}

HttpResponse DiagnoseApi::Correction(const HttpRequest& request) {
  constexpr std::array kControllers = {"rrf", "klipper", "marlin", "linuxcnc"};
  const Kept kept = Find(request.places[0]);
  const auto asked = request.query.find("for");
  if (asked == request.query.end() ||
      std::ranges::find(kControllers, asked->second) == kControllers.end()) {
    throw Problem(
        422,
        "for which controller?",
        {{.detail = fmt::format("?for= one of {}", fmt::join(kControllers, ", ")),
          .pointer = "/for"}});
  }
  const fs::path& folder = *kept.folder;
  const std::string name = "correction." + asked->second;
  std::vector<std::string> words = kept.words;
  words.insert(words.end(),
               {"--replay", "none", "--for", asked->second, "--correction", name});
  RunOwnProgram({.words = words, .folder = folder, .stop = stop_});
  Json tree{{"controller", asked->second}, {"files", Json::array()}};
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string found = entry.path().filename().string();
    if (found.starts_with(name)) names.push_back(found);
  }
  std::ranges::sort(names);
  for (const std::string& found : names) {
    tree["files"].push_back(
        {{"name", found}, {"text", ReadTextFile(folder / found, kLargestData_bytes)}});
  }
  return JsonResponse(tree);
}

}  // namespace caltwin
