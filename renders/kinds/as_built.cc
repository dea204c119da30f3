#include "renders/kinds/as_built.h"

#include <algorithm>

#include <fmt/format.h>

#include "renders/kinds/delta_scene.h"
#include "renders/kinds/triple_z_scene.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "sim/base/input_error.h"

namespace caltwin {
namespace {

// Enlarged as far as its rods still reach.
ReportPicture DeltaAsBuilt(const Scenario& scenario, std::uint64_t seed) {
  const Machine& machine = scenario.machine.machine;
  const BuiltDelta built =
      DrawDelta(*scenario.kind.As<DeltaScenario>(), machine, seed, /*sample=*/0);
  for (double exaggerate = kExaggerate;; exaggerate /= 2) {
    try {
      const DeltaScene scene(machine, built, std::max(exaggerate, 1.0));
      return {
          .title = "The machine as built.",
          .caption = fmt::format("Its geometric errors are enlarged {:g} times.",
                                 std::max(exaggerate, 1.0)),
          .png = PngBytes(DrawScene(scene.model(), scene.data(), RunPictureOptions()))};
    } catch (const InputError&) {
      if (exaggerate <= 1) throw;
    }
  }
}

ReportPicture TripleZAsBuilt(const Scenario& scenario, std::uint64_t seed) {
  const TripleZScene scene(DrawTripleZ(*scenario.kind.As<TripleZScenario>(),
                                       scenario.machine.machine,
                                       seed,
                                       /*sample=*/0),
                           kExaggerate);
  return {.title = "The machine as built.",
          .caption = fmt::format("Its bed's tilt is enlarged {} times.", kExaggerate),
          .png = PngBytes(DrawScene(scene.model(), scene.data(), RunPictureOptions()))};
}

}  // namespace

std::optional<std::vector<ReportPicture>> PicturesOfKind(const Scenario& scenario,
                                                         std::uint64_t seed) {
  if (scenario.kind.As<GantryScenario>() != nullptr) return std::nullopt;
  std::vector<ReportPicture> pictures;
  if (scenario.kind.As<DeltaScenario>() != nullptr) {
    pictures.push_back(DeltaAsBuilt(scenario, seed));
  }
  if (scenario.kind.As<TripleZScenario>() != nullptr) {
    pictures.push_back(TripleZAsBuilt(scenario, seed));
  }
  return pictures;
}

}  // namespace caltwin
