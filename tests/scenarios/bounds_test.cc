#include <string>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "scenarios/kinds/motor_stage_effects.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "sim/base/input_error.h"
#include "sim/effects/catalog.h"
#include "sim/kinds/delta/effects.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// Whether `{effect: {parameter: value}}` is refused where a machine's effects are read.
template <typename Read>
bool IsRefused(const std::string& effect,
               const std::string& parameter,
               double value,
               const Read& read) {
  Faults faults;
  read(ReadYamlText(
      fmt::format("{}: {{{}: {}}}\n", effect, parameter, value), "f", &faults));
  return !faults.empty();
}

// On every machine that has it, a parameter may go as far as it is declared, and no
// further.
TEST(BoundsOfAnEffect, AreThoseDeclaredOnEveryKindOfMachine) {
  const auto bounded_as_declared = [](const std::string& effect,
                                      const std::string& key,
                                      const std::string& parameter,
                                      const auto& read) {
    SCOPED_TRACE(key + "." + parameter);
    const auto bounds = DeclaredBounds(effect, parameter);
    ASSERT_TRUE(bounds);
    for (const double value : {bounds->min, bounds->max}) {
      EXPECT_FALSE(IsRefused(key, parameter, value, read)) << value;
    }
    const double beyond = 0.01 * (bounds->max - bounds->min);
    for (const double value : {bounds->min - beyond, bounds->max + beyond}) {
      EXPECT_TRUE(IsRefused(key, parameter, value, read)) << value;
    }
  };
  for (const MachineKind* kind : AllMachineKinds()) {
    const Machine machine{
        .kind = kind,
        .own = kind == DeltaKind() ? std::any(DeltaDrawing{}) : std::any()};
    const auto read = [&](const YamlMap& map) {
      if (kind == DeltaKind()) {
        ReadDeltaEffects(map, machine);
      } else {
        ReadEffects(map, machine);
      }
    };
    for (const Effect* effect : AllEffects()) {
      const auto axes = AxesOn(*effect, kind);
      if (axes.empty() || effect->name == "pitch_map" || effect->name == "unknown") {
        continue;  // Tables.
      }
      const std::string axis(axes[0] == kAnyAxis ? "first" : axes[0]);
      for (const Parameter& parameter : effect->parameters) {
        bounded_as_declared(
            std::string(effect->name),
            std::string(effect->name) + (axis.empty() ? "" : "." + axis),
            std::string(parameter.name),
            read);
      }
    }
  }
  const Machine delta{.kind = DeltaKind(), .own = DeltaDrawing{}};
  bounded_as_declared(
      "probe_pretravel", "probe_pretravel.z", "pretravel_mm", [&](const YamlMap& map) {
        ReadDeltaEffects(map, delta);
      });
  const MotorStageDrawing stage =
      MotorStageOf(ReadMachine(CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml"));
  bounded_as_declared("backlash", "backlash.x", "gap_mm", [&](const YamlMap& map) {
    ReadMotorEffects(map, stage);
  });
}

TEST(BoundsOfAnEffect, AreThoseDeclaredAtAStationInItsOwnUnit) {
  for (const auto& [key, most_mm] : {std::pair("bed_bowl_mm", 10.0),
                                     std::pair("endstop_scatter_mm", 1.0),
                                     std::pair("probe_scatter_mm", 1.0)}) {
    for (const auto& [times, faults] : {std::pair(1.0, 0U), std::pair(1.01, 1U)}) {
      Faults told;
      ReadStation(
          ReadYamlText(fmt::format("{}: {}\n", key, times * most_mm), "f", &told));
      EXPECT_EQ(told.empty(), faults == 0) << key << " " << times * most_mm;
    }
  }
}

}  // namespace
}  // namespace caltwin
