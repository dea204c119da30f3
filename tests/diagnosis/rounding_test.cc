#include "calibration/diagnosis/rounding.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calibration/diagnosis/remains.h"
#include "sim/base/units.h"
#include "tests/diagnosis/drawn_delta.h"

namespace caltwin {
namespace {

constexpr double kStep_mm = 0.0125;

DataHeader Stated(double sigma_um) {
  DataHeader header;
  for (const char* tower : {"a", "b", "c"}) {
    header.settings["s1"].steps_per_mm[tower] = 1 / kStep_mm;
  }
  header.instruments["probe"] = {.kind = "probe", .sigma_um = sigma_um};
  return header;
}

Row Touch(double x_mm, double y_mm, double value_mm) {
  Row row{.kind = RowKind::kTouch, .setup = "bed", .settings = "s1"};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = value_mm;
  return row;
}

Observed Touched(const std::vector<Row>& rows, const DataHeader& header) {
  return {{.rows = rows}, header, DrawnDelta(), {}};
}

// Each carriage counts for a third there: three thirds of a step, by chance.
TEST(RoundingSigma, InTheMiddleIsASixthOfAStep) {
  const Observed observed = Touched({Touch(0, 0, 0)}, Stated(0));

  EXPECT_NEAR(RoundingSigma_mm(observed, 0), kStep_mm / 6, 1e-9);
}

// Nearly all of the height is that tower's: the bound of one step alone.
TEST(RoundingSigma, UnderATowerIsNearlyThatOfOneStep) {
  const Observed observed = Touched({Touch(0, 100, 0)}, Stated(0));
  const double one_step_mm = kStep_mm / std::sqrt(12.0);

  EXPECT_GT(RoundingSigma_mm(observed, 0), 0.8 * one_step_mm);
  EXPECT_LT(RoundingSigma_mm(observed, 0), one_step_mm);
}

TEST(RoundingSigma, IsNotAssumedWhereNobodyStatesSteps) {
  EXPECT_EQ(RoundingSigma_mm(Touched({Touch(0, 0, 0)}, {}), 0), 0);
}

TEST(RoundingSigma, IsPartOfWhatIsStated) {
  constexpr double kProbe_um = 3;
  const Observed observed = Touched({Touch(0, 0, 0)}, Stated(kProbe_um));

  EXPECT_NEAR(
      observed.StatedSigma_mm(0), std::hypot(MmFromUm(kProbe_um), kStep_mm / 6), 1e-9);
}

// Repeats that count the same steps are equal, and yet no truer than a step.
TEST(NoiseFloor, IsNotBelowWholeSteps) {
  std::vector<Row> rows;
  for (int i = 0; i < 24; ++i) {
    const int place = i / 2;
    const double turn = place;
    rows.push_back(Touch(60 * std::cos(turn), 60 * std::sin(turn), kStep_mm));
  }
  const Observed observed = Touched(rows, Stated(1));
  SearchResult search;
  search.richest.sigma_mm = {0.005};
  search.richest.dof = {10};

  const std::vector<Floor> floors = FloorsOf(observed, search);

  ASSERT_EQ(floors.size(), 1U);
  EXPECT_EQ(floors[0].dof, 12);  // Of the replicates, not of the richest model.
  EXPECT_GE(floors[0].sigma_mm, kStep_mm / 6);
  EXPECT_LE(floors[0].sigma_mm, kStep_mm / std::sqrt(12.0));
}

}  // namespace
}  // namespace caltwin
