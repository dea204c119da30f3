#include "calibration/diagnosis/whole_tables.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::array kError_um = {
    4.0, -31.0, 12.0, 25.0, -8.0, 30.0, -22.0, 9.0, -15.0};
constexpr double kScale_um_per_mm = 1.5, kNoise_um = 0.5, kDrift_um = 3;
constexpr int kRuns = 5;

// Nine places 5 mm apart, each with an error of its own, on a scale that is off; runs
// that lie higher and higher.
Observed Zigzag() {
  Machine machine;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  RowTable table;
  Rng rng(1, 0, "whole tables");
  for (int run = 0; run < kRuns; ++run) {
    for (std::size_t place = 0; place < kError_um.size(); ++place) {
      Row row{.row = static_cast<int>(table.rows.size()) + 1,
              .campaign = "laser",
              .kind = RowKind::kPosition};
      row.n = {1, 0, 0};
      row.cmd_mm = {100 + 5 * static_cast<double>(place), 150, 50};
      row.dir = {1, 0, 0};
      row.rep = run + 1;
      row.value_mm =
          MmFromUm(kError_um[place] + kDrift_um * (run % 2) +
                   kScale_um_per_mm * row.cmd_mm[0] + kNoise_um * rng.Normal());
      table.rows.push_back(row);
    }
  }
  return {table, {}, machine, {}};
}

TEST(WholeTables, TableAndDrawingTogetherAreWhatWasMeasured) {
  const Observed observed = Zigzag();
  const Diagnosis diagnosis = Diagnose(observed, {});

  ASSERT_FALSE(diagnosis.findings.empty());
  ASSERT_TRUE(diagnosis.findings[0].map);
  const auto scale =
      std::ranges::find(diagnosis.baseline, "scale.x", &BaselineLine::name);
  ASSERT_NE(scale, diagnosis.baseline.end());
  EXPECT_FALSE(scale->is_determined);
  Eigen::VectorXd left_mm = observed.residual_mm();
  for (const Finding& finding : diagnosis.findings) left_mm -= finding.change_mm;
  left_mm.array() -= left_mm.mean();  // Where the laser's nought lies.
  EXPECT_LT(UmFromMm(std::sqrt(left_mm.squaredNorm() / 45)), kDrift_um);
}

// Of five runs at 0 3 0 3 0 um about their mean: the variance is 2.7 um^2.
TEST(WholeTables, TheNoiseFloorIsTheScatterOfReplicates) {
  const Diagnosis diagnosis = Diagnose(Zigzag(), {});

  ASSERT_TRUE(diagnosis.gain.floor_from_replicates);
  EXPECT_NEAR(UmFromMm(diagnosis.gain.noise_floor_mm),
              std::sqrt(2.7 + kNoise_um * kNoise_um),
              0.2);
}

}  // namespace
}  // namespace caltwin
