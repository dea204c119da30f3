// What smooth functions without a name can be.
#include "calibration/diagnosis/free_form.h"

#include <cmath>

#include <Eigen/QR>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

constexpr int kSide = 9;

// A bed of 200 mm, touched on a grid.
Observed Touched(Kinematics kinematics) {
  Machine machine{.name = "test", .kinematics = kinematics};
  if (kinematics == Kinematics::kTripleZ) machine.triple_z = TripleZDrawing{};
  RowTable table;
  for (int i = 0; i < kSide * kSide; ++i) {
    Row row{.row = i + 1, .campaign = "grid", .kind = RowKind::kTouch};
    row.cmd_mm = {25.0 * (i % kSide), 25.0 * std::floor(i / kSide), 0};
    row.n = {0, 0, 1};
    row.feature = "bed.top";
    table.rows.push_back(row);
  }
  return {table, {}, machine, {}};
}

// Share of a dent's squares, 60 mm wide about (80, 110), that no such form holds.
double LeftOfADent(TermsOfTwo which) {
  const Observed observed = Touched(Kinematics::kTripleZ);
  Eigen::VectorXd dent(observed.num_rows());
  for (Eigen::Index i = 0; i < dent.size(); ++i) {
    const Row& row = observed.row(i);
    const double far = std::hypot(row.cmd_mm[0] - 80, row.cmd_mm[1] - 110) / 60;
    dent[i] = std::max(0.0, 1 - far);
  }
  const FreeForm form = FreeFormOf(observed, "bed", {"x", "y"}, 20, which);
  Eigen::MatrixXd columns(dent.size(), form.columns_mm.cols() + 1);
  columns << form.columns_mm, Eigen::VectorXd::Ones(dent.size());
  const Eigen::VectorXd fitted =
      columns * columns.colPivHouseholderQr().solve(dent).eval();
  const Eigen::VectorXd flat = dent.array() - dent.mean();
  return (dent - fitted).squaredNorm() / flat.squaredNorm();
}

TEST(FreeForm, ADentIsNoProductOfWhatXAndYDo) {
  EXPECT_GT(LeftOfADent(TermsOfTwo::kProducts), 0.5);
  EXPECT_LT(LeftOfADent(TermsOfTwo::kAll), 0.1);
}

TEST(FreeForm, HasATermForEveryColumn) {
  const FreeForm form =
      FreeFormOf(Touched(Kinematics::kTripleZ), "bed", {"x", "y"}, 7, TermsOfTwo::kAll);
  EXPECT_EQ(form.columns_mm.cols(), 7);
  EXPECT_EQ(form.terms.size(), 7U);
}

// On a gantry, forms of x and of y alone stand beside that of both.
TEST(FreeForm, OfAPrintersBedHasTheTermsOfOneAlone) {
  const auto num_terms = [](Kinematics kinematics) {
    for (const FreeForm& form : AllFreeForms(Touched(kinematics))) {
      if (form.channel == "bed" && form.words.size() == 2) return form.terms.size();
    }
    return std::size_t{0};
  };
  EXPECT_EQ(num_terms(Kinematics::kCartesian), 10U);
  EXPECT_EQ(num_terms(Kinematics::kTripleZ), 18U);
}

}  // namespace
}  // namespace caltwin
