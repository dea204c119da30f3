#include "calibration/diagnosis/whole_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

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

// 21 places 4 mm apart, five times each, that err so.
Observed Along(const std::function<double(double)>& error_um) {
  constexpr int kPlaces = 21;
  Machine machine;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  RowTable table;
  Rng rng(2, 0, "along");
  for (int i = 0; i < kRuns * kPlaces; ++i) {
    Row row{.row = i + 1, .campaign = "laser", .kind = RowKind::kPosition};
    row.n = {1, 0, 0};
    row.cmd_mm = {100.0 + 4 * (i % kPlaces), 150, 50};
    row.dir = {1, 0, 0};
    row.rep = i / kPlaces + 1;
    row.value_mm = MmFromUm(error_um(row.cmd_mm[0]) + kNoise_um * rng.Normal());
    table.rows.push_back(row);
  }
  return {table, {}, machine, {}};
}

// A table was found first, and x's scale is not told beside it.
bool IsTableInPlaceOfScale(const Diagnosis& diagnosis) {
  const auto scale =
      std::ranges::find(diagnosis.baseline, "scale.x", &BaselineLine::name);
  return !diagnosis.findings.empty() && diagnosis.findings[0].map &&
         scale != diagnosis.baseline.end() && !scale->is_determined;
}

TEST(WholeTables, TableAndDrawingTogetherAreWhatWasMeasured) {
  const Observed observed = Zigzag();
  const Diagnosis diagnosis = Diagnose(observed, {});

  ASSERT_TRUE(IsTableInPlaceOfScale(diagnosis));
  Eigen::VectorXd left_mm = observed.residual_mm();
  for (const Finding& finding : diagnosis.findings) left_mm -= finding.change_mm;
  left_mm.array() -= left_mm.mean();  // Where the laser's nought lies.
  EXPECT_LT(UmFromMm(std::sqrt(left_mm.squaredNorm() / 45)), kDrift_um);
}

// A slope that a table of a kink can carry as well: the rows tell scale and table
// together ten times worse than the scale alone, and the table takes it all.
TEST(WholeTables, TheTableOfAKinkTakesTheSlope) {
  constexpr double kSlope_um_per_mm = 0.1, kKink_um_per_mm = 0.2, kAt_mm = 140;
  const Observed observed = Along([&](double x_mm) {
    return kSlope_um_per_mm * x_mm + kKink_um_per_mm * std::max(x_mm - kAt_mm, 0.0);
  });
  const Diagnosis diagnosis = Diagnose(observed, {});

  ASSERT_TRUE(IsTableInPlaceOfScale(diagnosis));
  const FreeMap& map = *diagnosis.findings[0].map;
  EXPECT_NEAR((map.values_um.back() - map.values_um.front()) /
                  (map.knots[0].back() - map.knots[0].front()),
              kSlope_um_per_mm + kKink_um_per_mm / 2,
              0.02);
}

// Of five runs at 0 3 0 3 0 um about their mean: the variance is 2.7 um^2.
TEST(WholeTables, TheNoiseFloorIsTheScatterOfReplicates) {
  const Diagnosis diagnosis = Diagnose(Zigzag(), {});

  ASSERT_TRUE(diagnosis.gain.floor_from_replicates);
  EXPECT_NEAR(UmFromMm(diagnosis.gain.noise_floor_mm),
              std::sqrt(2.7 + kNoise_um * kNoise_um),
              0.2);
}

// A plate that leans by 2 mrad, with a wave of 20 um along x: how it leans nothing but
// the plate itself tells, and the wave is 20 um high, however the plate lies. All
// touches are told to end at one height, so none of it is an error along z.
TEST(WholeTables, APlatesLeaningIsNoPartOfATable) {
  constexpr double kWave_um = 20, kLean_mrad = 2;
  Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  RowTable table;
  Rng rng(3, 0, "leaning plate");
  for (int i = 0; i < 162; ++i) {
    const double x_mm = 30 + 30 * (i % 9), y_mm = 30 + 30 * (i / 9 % 9);
    Row row{.row = i + 1,
            .campaign = "plate",
            .kind = RowKind::kTouch,
            .setup = "plate",
            .rep = i / 81 + 1};
    row.n = {0, 0, 1};
    row.dir = {0, 0, -1};
    row.cmd_mm = {x_mm, y_mm, 20};
    row.feature = "plate.top";
    row.value_mm = MmFromUm(kWave_um * std::sin(x_mm / 40) + kLean_mrad * x_mm +
                            0.5 * rng.Normal());
    table.rows.push_back(row);
  }

  const Diagnosis diagnosis = Diagnose({table, {}, machine, {}}, {});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  const Finding& found = diagnosis.findings[0];
  ASSERT_TRUE(found.map);
  EXPECT_EQ(found.covariates, std::vector<std::string>{"x"});
  EXPECT_NEAR(found.peak_um, kWave_um, 4);
  for (const EvidenceLine& line : diagnosis.weighed) {
    if (line.cause != "unknown") continue;
    EXPECT_EQ(std::ranges::count(line.covariates, "z"), 0);
  }
}

}  // namespace
}  // namespace caltwin
