#include "tools/commands/api/catalog_api.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/procedures/catalog.h"
#include "scenarios/file_kind.h"
#include "scenarios/machine_file.h"
#include "scenarios/scenario.h"
#include "sim/base/input_error.h"
#include "sim/base/temporary_folder.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine_kind.h"
#include "tools/commands/api/own_program.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// The comment at the head of a file, its lines joined.
std::string HeadComment(const fs::path& file) {
  std::string_view text;
  const std::string whole = ReadTextFile(file, kLargestFile_bytes);
  text = whole;
  std::string comment;
  while (text.starts_with('#')) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(1, end - 1);
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    comment += (comment.empty() ? "" : " ") + std::string(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return comment;
}

fs::path ModelFile(const std::string& name) {
  return ShareFolder() / "models" / name / "machine.yaml";
}

HttpResponse Machines(const HttpRequest&) {
  Json list = Json::array();
  for (const std::string& name : ModelNames()) {
    const Machine machine = ReadAnyMachineFile(ModelFile(name)).machine;
    list.push_back({{"name", name},
                    {"kinematics", std::string(machine.kind->name())},
                    {"about", HeadComment(ModelFile(name))},
                    {"picture", fmt::format("/api/machines/{}/picture", name)}});
  }
  return JsonResponse({{"machines", std::move(list)}});
}

HttpResponse Picture(const HttpRequest& request) {
  const std::string& name = request.places[0];
  RequireAmong(ModelNames(), name);
  const double exaggerate = ExaggerateOf(request);
  const TemporaryFolder folder("caltwin_server");
  RunOwnProgram({.words = {"render",
                           ModelFile(name).string(),
                           "--out",
                           "picture.png",
                           "--width",
                           "960",
                           "--height",
                           "640",
                           "--exaggerate",
                           fmt::format("{:g}", exaggerate)},
                 .folder = folder.path(),
                 .is_confined = false});
  return {.content_type = "image/png",
          .body = ReadTextFile(folder.path() / "picture.png", kLargestData_bytes),
          .headers = {{"Cache-Control", "private, max-age=3600"}}};
}

HttpResponse Scenarios(const HttpRequest&) {
  static std::mutex mutex;
  static std::string answer;
  const std::lock_guard<std::mutex> lock(mutex);
  if (answer.empty()) {
    Json list = Json::array();
    for (const std::string& name : ScenarioNames()) {
      const fs::path file = ShareFolder() / "scenarios" / (name + ".yaml");
      const Scenario scenario = ReadScenario(file);
      list.push_back(
          {{"name", name},
           {"about", scenario.about},
           {"machine", scenario.machine.machine.name},
           {"kinematics", std::string(scenario.machine.machine.kind->name())}});
    }
    answer = JsonResponse({{"scenarios", std::move(list)}}).body;
  }
  return {.body = answer};
}

HttpResponse ProceduresList(const HttpRequest&) {
  Json list = Json::array();
  for (const Procedure* const procedure : AllProcedures()) {
    list.push_back({{"name", std::string(procedure->name)},
                    {"about", std::string(procedure->about)},
                    {"source", std::string(procedure->source)},
                    {"published", std::string(procedure->published)},
                    {"physics", std::string(procedure->physics)},
                    {"has_variants", procedure->has_variants},
                    {"kind", std::string(procedure->kind)}});
  }
  return JsonResponse({{"procedures", std::move(list)}});
}

HttpResponse Explain(const HttpRequest& request) {
  const std::string& name = request.places[0];
  const bool is_word = std::ranges::all_of(name, [](char letter) {
    return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_' ||
           letter == '.';
  });
  if (!is_word)
    throw Problem(422, "that is no word", {{.detail = "letters, digits, _"}});
  const std::string text = RunOwnProgram({.words = {"explain", name}});
  return JsonResponse({{"name", name}, {"text", text}});
}

}  // namespace

std::vector<std::string> ModelNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(ShareFolder() / "models", error)) {
    const std::string name = entry.path().filename().string();
    if (fs::exists(ModelFile(name), error)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(ShareFolder() / "scenarios", error)) {
    if (entry.path().extension() == ".yaml")
      names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

double ExaggerateOf(const HttpRequest& request) {
  const auto asked = request.query.find("exaggerate");
  if (asked == request.query.end()) return 1;
  double times = 0;
  const char* const end = asked->second.data() + asked->second.size();
  const auto read = std::from_chars(asked->second.data(), end, times);
  if (read.ec == std::errc() && read.ptr == end && times >= 1 && times <= 1e6)
    return times;
  throw Problem(422,
                "exaggerate is no factor",
                {{.detail = "a number from 1 to 1000000", .pointer = "/exaggerate"}});
}

void RequireAmong(const std::vector<std::string>& known, const std::string& name) {
  if (std::ranges::find(known, name) != known.end()) return;
  throw Problem(404, fmt::format("there is no '{}'", Printable(name)));
}

void AddCatalogTo(Routes* routes) {
  const auto add = [&](const char* path, Handler go) {
    routes->Add({.method = "GET",
                 .pattern = path,
                 .handler = std::move(go),
                 .pace = Route::Pace::kSlow});
  };
  add("/api/machines", Machines);
  add("/api/machines/{}/picture", Picture);
  add("/api/scenarios", Scenarios);
  add("/api/procedures", ProceduresList);
  add("/api/explain/{}", Explain);
}

}  // namespace caltwin
