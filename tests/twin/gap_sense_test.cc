// Just after a reversal a carriage stands where it was until its nut has crossed the
// gap: closed form and MuJoCo.
#include "sim/effects/gap_sense.h"

#include <gtest/gtest.h>

#include "tests/twin/measured_rows.h"

namespace caltwin {
namespace {

constexpr double kGap_mm = 0.1;

Row ReadAlongX(double since_rev_mm, double dir) {
  return {.row = 1,
          .campaign = "reversal",
          .settings = "1",
          .cmd_mm = {150, 150, 60},
          .dir = {dir, 1, 1},
          .since_rev_mm = {since_rev_mm, 50, 50},
          .n = {1, 0, 0}};
}

// What the laser shows of a machine with that gap and compensation along x.
RowTable ShownOf(std::vector<Row> rows, double compensation_mm, Fidelity fidelity) {
  Machine machine = Gantry();
  machine.settings.backlash_mm[0] = compensation_mm;
  return Perform({.machine = machine,
                  .effects = {{.effect = EffectIndex<Backlash>(),
                               .axis = "x",
                               .values = {kGap_mm}}},
                  .fidelity = fidelity,
                  .is_noisy = false},
                 std::move(rows));
}

class JustAfterReversal : public ::testing::TestWithParam<Fidelity> {};

TEST_P(JustAfterReversal, CarriageStandsUntilTheGapIsCrossed) {
  constexpr double kNeglected_mm = 0.5e-3;  // docs/fidelities.md.
  std::vector<Row> rows;
  for (const double dir : {-1.0, 1.0}) {
    for (const double d_mm : {0.0, 0.01, 0.03, 0.059, 0.07, 0.2}) {
      rows.push_back(ReadAlongX(d_mm, dir));
    }
  }
  for (const double compensation_mm : {0.0, 0.04}) {
    for (const Row& row : ShownOf(rows, compensation_mm, GetParam()).rows) {
      const double left_mm = kGap_mm - compensation_mm;
      const double crossed_mm = std::min(row.since_rev_mm[0], left_mm);

      EXPECT_NEAR(row.value_mm, row.dir[0] * (left_mm / 2 - crossed_mm), kNeglected_mm)
          << row.dir[0] << " " << compensation_mm << " " << row.since_rev_mm[0];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fidelities,
                         JustAfterReversal,
                         ::testing::Values(Fidelity::kFast, Fidelity::kPhysics),
                         [](const auto& fidelity) {
                           return std::string(
                               fidelity.param == Fidelity::kFast ? "fast" : "physics");
                         });

TEST(GapSense, LeavesWhatTouchesAndWhatIsNotKnownAlone) {
  At at{.kind = RowKind::kTouch, .dir = {1, 1, 1}, .n = {-1, 0, 0}};
  at.since_rev_mm = {0.01, kUnknown, 0.01};

  const Vec3<double> sense = GapSense(at, Vec3<double>::Constant(kGap_mm));

  EXPECT_EQ(sense[0], 1);
  EXPECT_EQ(sense[1], 1);
  EXPECT_NEAR(sense[2], -0.8, 1e-12);
}

}  // namespace
}  // namespace caltwin
