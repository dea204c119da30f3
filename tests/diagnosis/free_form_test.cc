// What a shape without a name can follow.
#include "calibration/diagnosis/free_form.h"

#include <cmath>
#include <numbers>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr Eigen::Index kRows = 61;

// A laser along x from 0 to 300 mm.
Observed Line() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  RowTable table;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    Row row{.row = i + 1, .campaign = "line"};
    row.cmd_mm = {5 * static_cast<double>(i), 0, 0};
    row.n = {1, 0, 0};
    table.rows.push_back(row);
  }
  return {table, {}, machine, {}};
}

constexpr int kTerms = 10;

// The same as columns of cosines alone.
Eigen::MatrixXd Cosines() {
  Eigen::MatrixXd columns(kRows, kTerms);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    for (int k = 1; k <= kTerms; ++k) {
      columns(i, k - 1) =
          std::cos(k * std::numbers::pi * static_cast<double>(i) / (kRows - 1));
    }
  }
  return columns;
}

// Root mean square of what an offset and these columns cannot follow of a `shape` of
// u = -1 .. 1 along the line.
template <typename Shape>
double LeftOf(const Eigen::MatrixXd& columns, const Shape& shape) {
  Eigen::MatrixXd all(kRows, columns.cols() + 1);
  all << columns, Eigen::VectorXd::Ones(kRows);
  Eigen::VectorXd wanted(kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    wanted[i] = shape(2 * static_cast<double>(i) / (kRows - 1) - 1);
  }
  const Eigen::VectorXd fit = all.householderQr().solve(wanted);
  return (wanted - all * fit).norm() / std::sqrt(kRows);
}

class FreeFormTest : public ::testing::Test {
 protected:
  const Eigen::MatrixXd form_ = FreeFormOf(Line(), "x", {"x"}, 20).columns_mm;
};

TEST_F(FreeFormTest, HoldsALineAndABowExactly) {
  EXPECT_LT(LeftOf(form_, [](double u) { return u; }), 1e-12);
  EXPECT_LT(LeftOf(form_, [](double u) { return u * u; }), 1e-12);
}

// A screw that runs away at its ends: cosines are flat there.
TEST_F(FreeFormTest, FollowsSlopesAtTheEndsBetterThanCosines) {
  const auto cubic = [](double u) {
    return u * u * u;
  };
  const auto quartic = [](double u) {
    return u * u * u * u;
  };
  EXPECT_LT(LeftOf(form_, cubic), 0.2 * LeftOf(Cosines(), cubic));
  EXPECT_LT(LeftOf(form_, quartic), 0.2 * LeftOf(Cosines(), quartic));
}

// Beside them it has the cosines whole.
TEST_F(FreeFormTest, FollowsCosinesOfLowOrder) {
  for (int order = 1; order <= kTerms; ++order) {
    const auto cosine = [&](double u) {
      return std::cos(0.5 * order * std::numbers::pi * (u + 1));
    };
    EXPECT_LT(LeftOf(form_, cosine), 1e-9) << order;
  }
}

constexpr int kSide = 9;

// A bed of 200 mm, touched on a grid.
Observed Touched(const MachineKind* kind) {
  Machine machine{.name = "test", .kind = kind};
  if (kind == TripleZKind()) machine.own = TripleZDrawing{};
  RowTable table;
  for (int i = 0; i < kSide * kSide; ++i) {
    Row row{.row = i + 1, .campaign = "grid", .kind = RowKind::kTouch};
    const int across = i % kSide, up = i / kSide;
    row.cmd_mm = {25.0 * across, 25.0 * up, 0};
    row.n = {0, 0, 1};
    row.feature = "bed.top";
    table.rows.push_back(row);
  }
  return {table, {}, machine, {}};
}

// Share of a dent's squares, 60 mm wide about (80, 110), that no such form holds.
double LeftOfADent(TermsOfTwo which) {
  const Observed observed = Touched(TripleZKind());
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

TEST(FreeFormOfTwo, ADentIsNoProductOfWhatXAndYDo) {
  EXPECT_GT(LeftOfADent(TermsOfTwo::kProducts), 0.5);
  EXPECT_LT(LeftOfADent(TermsOfTwo::kAll), 0.1);
}

TEST(FreeFormOfTwo, HasATermForEveryColumn) {
  const FreeForm form =
      FreeFormOf(Touched(TripleZKind()), "bed", {"x", "y"}, 7, TermsOfTwo::kAll);
  EXPECT_EQ(form.columns_mm.cols(), 7);
  EXPECT_EQ(form.terms.size(), 7U);
}

// On a gantry, forms of x and of y alone stand beside that of both.
TEST(FreeFormOfTwo, OfAPrintersBedHasTheTermsOfOneAlone) {
  const auto num_terms = [](const MachineKind* kind) {
    for (const FreeForm& form : AllFreeForms(Touched(kind))) {
      if (form.channel == "bed" && form.words.size() == 2) return form.terms.size();
    }
    return std::size_t{0};
  };
  EXPECT_EQ(num_terms(CartesianKind()), 10U);
  EXPECT_EQ(num_terms(TripleZKind()), 18U);
}

}  // namespace
}  // namespace caltwin
