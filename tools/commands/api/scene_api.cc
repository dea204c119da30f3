#include "tools/commands/api/scene_api.h"

#include <algorithm>
#include <filesystem>
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

void SceneApi::Add(Routes* routes,
                   const std::string& below,
                   const std::function<Shown(const HttpRequest&)>& shown) {
  routes->Add(
      {.method = "GET",
       .pattern = below + "/scene",
       .handler = [this, shown](const HttpRequest& r) { return Scene(shown(r), r); },
       .pace = Route::Pace::kSlow});
  routes->Add(
      {.method = "POST",
       .pattern = below + "/poses",
       .handler = [this, shown](const HttpRequest& r) { return Poses(shown(r), r); },
       .pace = Route::Pace::kSlow});
}

void SceneApi::AddTo(Routes* routes, const std::optional<TwinFiles>& bench) {
  const auto add = [&](const std::string& kind, auto names, auto file_of) {
    Add(routes, "/api/" + kind + "/{}", [names, file_of](const HttpRequest& request) {
      RequireAmong(names(), request.places[0]);
      const fs::path file = file_of(request.places[0]);
      return Shown{file.string(), [file](double exaggerate) {
                     return StillOf(file, exaggerate);
                   }};
    });
  };
  add("machines", ModelNames, [](const std::string& name) {
    return ShareFolder() / "models" / name / "machine.yaml";
  });
  add("scenarios", ScenarioNames, [](const std::string& name) {
    return ShareFolder() / "scenarios" / (name + ".yaml");
  });
  Add(routes, "/api/bench", [bench](const HttpRequest&) {
    if (!bench) {
      throw Problem(404,
                    "the machine on the bench is a real one",
                    {{.detail = "nobody knows its errors, nor where its workpiece lies",
                      .hint = "GET /api/machines/NAME/scene is its drawing"}});
    }
    return Shown{"bench", [twin = *bench](double exaggerate) {
                   return StillOf(twin, exaggerate);
                 }};
  });
}

SceneApi::Kept* SceneApi::Find(const Shown& shown, double exaggerate) {
  const auto found = std::ranges::find_if(kept_, [&](const Kept& one) {
    return one.key == shown.key && one.exaggerate == exaggerate;
  });
  if (found != kept_.end()) return &*found;
  kept_.push_back({shown.key, exaggerate, shown.make(exaggerate)});
  if (kept_.size() > kMostKept) kept_.pop_front();
  return &kept_.back();
}

HttpResponse SceneApi::Scene(const Shown& shown, const HttpRequest& request) {
  const double exaggerate = ExaggerateOf(request);
  const std::lock_guard<std::mutex> lock(mutex_);
  return JsonResponse(SceneJson(Find(shown, exaggerate)->still));
}

HttpResponse SceneApi::Poses(const Shown& shown, const HttpRequest& request) {
  const double exaggerate = ExaggerateOf(request);
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  const auto positions = keys.Tuples("positions", 3, 1, kMostPositions);
  keys.Done();
  const std::lock_guard<std::mutex> lock(mutex_);
  const Kept& kept = *Find(shown, exaggerate);
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
