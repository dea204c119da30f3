// A printer's station that measures: MuJoCo against the closed forms.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/kinds/perform.h"
#include "sim/kinds/z_station/machine.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

constexpr double kMust_mm = 1e-4;

Machine Station() {
  return ReadMachine(CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml");
}

PlannedSession Session() {
  const Plan plan = ReadPlanText(
      "campaigns:\n"
      "  - z_offset: {rounds: 4, repeats: 1, nozzle_c: [25, 240], bed_c: [25, 90], "
      "chamber_c: [25]}\n"
      "  - z_gap: {rounds: 2, nozzle_c: [25, 240], chamber_c: [25, 50]}\n",
      "plan.yaml");
  return PlanSession(plan, Station(), /*seed=*/1);
}

std::vector<double> Read_mm(Fidelity fidelity, const std::vector<Injected>& effects) {
  const PlannedSession session = Session();
  const RowTable table = Perform({.machine = Station(),
                                  .effects = effects,
                                  .header = session.header,
                                  .fidelity = fidelity,
                                  .is_noisy = false},
                                 session.rows);
  std::vector<double> values_mm;
  for (const Row& row : table.rows) values_mm.push_back(row.value_mm);
  return values_mm;
}

double Span_mm(const std::vector<double>& values_mm) {
  const auto [least, most] = std::ranges::minmax(values_mm);
  return most - least;
}

class EveryStationEffect : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryStationEffect, TouchesInMuJoCoWhereTheClosedFormSays) {
  const int index = *FindEffect(GetParam());
  for (const std::string_view axis : AxesOn(EffectAt(index), ZStationKind())) {
    Injected effect = NeutralEffect(index, axis, Station());
    effect.values[0] = GetParam() == "random_walk" ? 20 : 2;
    if (effect.values.size() > 1) effect.values[1] = 1000;  // Of moments: in between.
    if (GetParam() == "ooze") effect.values = {150, 180};

    const auto fast_mm = Read_mm(Fidelity::kFast, {effect});
    const auto physics_mm = Read_mm(Fidelity::kPhysics, {effect});

    ASSERT_EQ(fast_mm.size(), physics_mm.size());
    for (std::size_t i = 0; i < fast_mm.size(); ++i) {
      EXPECT_NEAR(physics_mm[i], fast_mm[i], kMust_mm) << axis << " row " << i + 1;
    }
    // What all three touches share, the homing before them takes out.
    const bool is_shared = axis == "frame" || axis == "z" ||
                           GetParam() == "frame_growth" ||
                           GetParam() == "trigger_scatter";
    EXPECT_EQ(Span_mm(fast_mm) > 1e-3, !is_shared) << axis;
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryStationEffect,
                         ::testing::Values("nozzle_temperature",
                                           "ooze",
                                           "switch_offset",
                                           "station_change",
                                           "frame_temperature",
                                           "frame_growth",
                                           "probe_temperature",
                                           "random_walk",
                                           "missed_steps",
                                           "trigger_scatter"),
                         [](const auto& test) { return test.param; });

// Head and nozzle as drawn: all that is touched is where the plan says.
TEST(ZStationMachine, AsDrawnReadsNothing) {
  for (const double value_mm : Read_mm(Fidelity::kPhysics, {})) {
    EXPECT_NEAR(value_mm, 0, kMust_mm);
  }
}

// What is homed with the nozzle on the switch counts from there: a longer nozzle reads
// as all else lower, and the gap after calibration does not feel it.
TEST(ZStationMachine, CountsFromWhereTheNozzleMetTheSwitch) {
  const Injected grown{
      .effect = EffectIndex<NozzleTemperature>(), .axis = "", .values = {0.5, 0}};
  const PlannedSession session = Session();
  const auto values_mm = Read_mm(Fidelity::kFast, {grown});
  const double first_c = session.rows[0].temp_nozzle_c;
  for (std::size_t i = 0; i < values_mm.size(); ++i) {
    const Row& row = session.rows[i];
    const double longer_mm = 0.0005 * (row.temp_nozzle_c - first_c);
    const bool is_other = row.feature == "switch.body" || row.feature == "bed.probe";
    EXPECT_NEAR(values_mm[i], is_other ? -longer_mm : 0, 1e-9) << row.feature;
  }
}

}  // namespace
}  // namespace caltwin
