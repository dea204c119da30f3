#include "tools/commands/api/scene_api.h"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renders/scene_json.h"
#include "scenarios/file_kind.h"
#include "scenarios/machine_file.h"
#include "scenarios/scenario.h"
#include "sim/base/text_file.h"
#include "tools/commands/api/catalog_api.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostKept = 4;
constexpr std::size_t kMostPositions = 400;

}  // namespace

void SceneApi::AddTo(Routes* routes) {
  const auto add = [&](const std::string& kind, auto names, auto file_of) {
    const auto file = [names, file_of](const HttpRequest& request) {
      RequireAmong(names(), request.places[0]);
      return file_of(request.places[0]);
    };
    routes->Add(
        {.method = "GET",
         .pattern = "/api/" + kind + "/{}/scene",
         .handler = [this, file](const HttpRequest& r) { return Scene(file(r), r); },
         .pace = Route::Pace::kSlow});
    routes->Add(
        {.method = "POST",
         .pattern = "/api/" + kind + "/{}/poses",
         .handler = [this, file](const HttpRequest& r) { return Poses(file(r), r); },
         .pace = Route::Pace::kSlow});
  };
  add("machines", ModelNames, [](const std::string& name) {
    return ShareFolder() / "models" / name / "machine.yaml";
  });
  add("scenarios", ScenarioNames, [](const std::string& name) {
    return ShareFolder() / "scenarios" / (name + ".yaml");
  });
}

SceneApi::Kept* SceneApi::Find(const fs::path& file, double exaggerate) {
  const auto found = std::ranges::find_if(kept_, [&](const Kept& one) {
    return one.file == file && one.exaggerate == exaggerate;
  });
  if (found != kept_.end()) return &*found;
  kept_.push_back({file, exaggerate, StillOf(file, exaggerate)});
  if (kept_.size() > kMostKept) kept_.pop_front();
  return &kept_.back();
}

HttpResponse SceneApi::Scene(const fs::path& file, const HttpRequest& request) {
  const double exaggerate = ExaggerateOf(request);
  const std::lock_guard<std::mutex> lock(mutex_);
  return JsonResponse(SceneJson(Find(file, exaggerate)->still));
}

HttpResponse SceneApi::Poses(const fs::path& file, const HttpRequest& request) {
  const double exaggerate = ExaggerateOf(request);
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  const auto positions = keys.Tuples("positions", 3, 1, kMostPositions);
  keys.Done();
  const std::lock_guard<std::mutex> lock(mutex_);
  const Kept& kept = *Find(file, exaggerate);
  if (!kept.still.move_to) throw Problem(409, "this machine has no tip to move");
  const std::vector<int> moving = MovingBodies(*kept.still.model);
  Json poses = Json::array();
  for (const auto& at : positions) {
    const bool is_there = kept.still.move_to({at[0], at[1], at[2]});
    poses.push_back(is_there ? PosesJson(*kept.still.data, moving) : Json());
  }
  return JsonResponse({{"bodies", moving}, {"poses", std::move(poses)}});
}

}  // namespace caltwin
