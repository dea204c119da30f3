#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "calibration/estimate/baseline.h"
#include "sim/base/rng.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

RowTable Real(const std::string& file) {
  return ReadRows(std::filesystem::path(CALTWIN_SOURCE_DIR) / "tests/data/iso230" /
                  file);
}

// A figure of the source is given to a tenth of a micrometre.
constexpr double kPrinted_mm = 0.00005;

TEST(Baseline, TargetDriveXHasThePublishedResiduals) {
  const RowTable table = Real("ess_target_x_2022-04.csv");

  const BaselineFit straight = FitBaseline(table, {.reversal = false});
  const BaselineFit with_reversal = FitBaseline(table);

  EXPECT_NEAR(straight.rms_mm, 0.0330, kPrinted_mm);
  EXPECT_NEAR(with_reversal.rms_mm, 0.0304, kPrinted_mm);
  ASSERT_NE(with_reversal.Find("backlash.x"), nullptr);
  EXPECT_NEAR(with_reversal.Find("backlash.x")->value, 0.0254, kPrinted_mm);
  EXPECT_TRUE(with_reversal.Find("backlash.x")->identifiable);
}

TEST(Baseline, TargetDriveYHasThePublishedResiduals) {
  const RowTable table = Real("ess_target_y_2022-04.csv");

  EXPECT_NEAR(FitBaseline(table, {.reversal = false}).rms_mm, 0.0242, kPrinted_mm);
  const BaselineFit with_reversal = FitBaseline(table);
  EXPECT_NEAR(with_reversal.rms_mm, 0.0234, kPrinted_mm);
  EXPECT_NEAR(with_reversal.Find("backlash.y")->value, 0.0128, kPrinted_mm);
}

// A laser on one axis: moves `scale` too far, loses `gap` at a reversal.
RowTable Laser(double scale, double gap_mm, double sigma_mm, Rng* rng) {
  RowTable table;
  for (const int dir : {+1, -1}) {
    for (int i = 0; i <= 20; ++i) {
      const double cmd_mm = 15.0 * i;
      Row row{.row = static_cast<std::int64_t>(table.rows.size() + 1),
              .campaign = "laser"};
      row.cmd_mm[0] = cmd_mm;
      row.n = {1, 0, 0};
      row.dir[0] = dir;
      row.value_mm = 0.3 + scale * cmd_mm - dir * gap_mm / 2 + sigma_mm * rng->Normal();
      table.rows.push_back(row);
    }
  }
  return table;
}

TEST(Baseline, RecoversScaleBacklashAndOffset) {
  Rng rng(1, 0, "baseline");

  const BaselineFit fit = FitBaseline(Laser(200e-6, 0.04, 0, &rng));

  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.Find("scale.x")->value, 200, 1e-4);
  EXPECT_EQ(fit.Find("scale.x")->unit, "ppm");
  EXPECT_NEAR(fit.Find("backlash.x")->value, 0.04, 1e-9);
  EXPECT_NEAR(fit.Find("placement.laser.x")->value, 0.3, 1e-9);
}

TEST(Baseline, StatesTheClosedFormUncertainty) {
  Rng rng(2, 0, "baseline");

  const BaselineFit fit = FitBaseline(Laser(0, 0.04, 0.002, &rng));

  // 42 rows, 3 unknowns: s from the residuals; sd(b) = 2 s / sqrt(42), sd(scale) = s /
  // sqrt(sum (q - mean)^2), sum = 2 * 15^2 * 770.
  const double s_mm = fit.rms_mm * std::sqrt(42.0 / 39);
  EXPECT_NEAR(fit.dof, 39, 1e-3);
  EXPECT_NEAR(fit.Find("backlash.x")->sd, 2 * s_mm / std::sqrt(42), 1e-8);
  EXPECT_NEAR(fit.Find("scale.x")->sd, 1e6 * s_mm / std::sqrt(2 * 225.0 * 770), 1e-4);
}

TEST(Baseline, OneSenseDoesNotTellTheBacklash) {
  Rng rng(3, 0, "baseline");
  RowTable table = Laser(0, 0.04, 0.001, &rng);
  std::erase_if(table.rows, [](const Row& row) { return row.dir[0] < 0; });

  const BaselineFit fit = FitBaseline(table);

  EXPECT_FALSE(fit.Find("backlash.x")->identifiable);
  EXPECT_TRUE(fit.Find("scale.x")->identifiable);
}

TEST(Baseline, EveryCampaignHasItsOwnOffset) {
  Rng rng(4, 0, "baseline");
  RowTable table = Laser(100e-6, 0.02, 0, &rng);
  for (Row row : Laser(100e-6, 0.02, 0, &rng).rows) {
    row.campaign = "second";
    row.value_mm += 1;
    table.rows.push_back(row);
  }

  const BaselineFit fit = FitBaseline(table);

  EXPECT_NEAR(fit.rms_mm, 0, 1e-9);
  EXPECT_NEAR(fit.Find("placement.second.x")->value, 1.3, 1e-9);
}

TEST(Baseline, AxesInOneTableAreFittedAsIfAlone) {
  RowTable both = Real("ess_target_x_2022-04.csv");
  const RowTable y = Real("ess_target_y_2022-04.csv");
  both.rows.insert(both.rows.end(), y.rows.begin(), y.rows.end());

  const BaselineFit fit = FitBaseline(both);

  EXPECT_NEAR(fit.Find("backlash.x")->value, 0.0254, kPrinted_mm);
  EXPECT_NEAR(fit.Find("backlash.y")->value, 0.0128, kPrinted_mm);
}

TEST(Baseline, TouchesTellPretravelAndBacklashOnlyTogether) {
  RowTable table;
  for (const double place_mm : {0.0, 100.0}) {
    for (const int normal : {-1, +1}) {
      Row row{.kind = RowKind::kTouch, .setup = "block"};
      row.cmd_mm = {place_mm + normal * 10, 0, 0};
      row.n = {static_cast<double>(normal), 0, 0};
      row.dir = {static_cast<double>(-normal), 0, 0};
      row.value_mm = -0.045;  // pre-travel 0.02 and half a gap of 0.05
      table.rows.push_back(row);
    }
  }

  const BaselineFit fit = FitBaseline(table);

  EXPECT_FALSE(fit.Find("probe_pretravel.x")->identifiable);
  ASSERT_EQ(fit.observability.blind.size(), 1u);
  EXPECT_EQ(fit.observability.blind[0].statement,
            "probe_pretravel.x + backlash.x / 2 only");
  // Beliefs of 0.02 and 0.05 mm already have that sum.
  EXPECT_NEAR(fit.Find("backlash.x")->value, 0.05, 1e-4);
}

}  // namespace
}  // namespace caltwin
