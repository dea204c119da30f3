#include "renders/kinds/as_built.h"

#include <string_view>

#include <fmt/format.h>

#include "renders/kinds/still.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"

namespace caltwin {
namespace {

ReportPicture AsBuilt(const Scenario& scenario,
                      std::uint64_t seed,
                      std::string_view enlarged) {
  const Enlarged drawn = EnlargedStillOf(scenario, seed, kExaggerate);
  return {.title = "The machine as built.",
          .caption = fmt::format("{} enlarged {:g} times.", enlarged, drawn.exaggerate),
          .png = PngBytes(
              DrawScene(drawn.still.model, drawn.still.data, RunPictureOptions()))};
}

}  // namespace

std::optional<std::vector<ReportPicture>> PicturesOfKind(const Scenario& scenario,
                                                         std::uint64_t seed) {
  if (scenario.kind.As<GantryScenario>() != nullptr) return std::nullopt;
  std::vector<ReportPicture> pictures;
  if (scenario.kind.As<DeltaScenario>() != nullptr) {
    pictures.push_back(AsBuilt(scenario, seed, "Its geometric errors are"));
  }
  if (scenario.kind.As<TripleZScenario>() != nullptr) {
    pictures.push_back(AsBuilt(scenario, seed, "Its bed's tilt is"));
  }
  if (scenario.kind.As<ZStationScenario>() != nullptr) {
    pictures.push_back(AsBuilt(scenario, seed, "How far its parts stand off is"));
  }
  return pictures;
}

}  // namespace caltwin
