#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "calibration/diagnosis/candidates.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

constexpr double kRim_mm = 100;

Machine Delta() {
  return {.kind = DeltaKind(), .own = DeltaDrawing{}};
}

// Touches of a bed on five rings.
Observed Touched() {
  RowTable table;
  for (int i = 0; i < 60; ++i) {
    const double out_mm = kRim_mm * (1 + i % 5) / 5;
    const double turn = 2 * std::numbers::pi * i / 12;
    Row row{.row = i + 1, .campaign = "grid", .kind = RowKind::kTouch, .setup = "bed"};
    row.cmd_mm = {out_mm * std::cos(turn), out_mm * std::sin(turn), 0};
    row.n = {0, 0, 1};
    row.feature = "bed.top";
    row.value_mm = 0;
    table.rows.push_back(row);
  }
  return {table, {}, Delta(), {}};
}

const Candidate& Named(const std::vector<Candidate>& all, const std::string& name) {
  return *std::ranges::find(all, name, &Candidate::Name);
}

// How much of `shape` a bend and its freedom leave, of its root sum of squares.
double Left(const Observed& observed,
            const Candidate& bend,
            const Eigen::VectorXd& shape) {
  const Variant& variant = bend.variants.front();
  const Tolerance free = ToleranceOf(observed, bend, variant);
  Eigen::MatrixXd all(shape.size(), variant.columns_mm.cols() + free.columns_mm.cols());
  all << variant.columns_mm, free.columns_mm;
  const Eigen::VectorXd fit = all * all.colPivHouseholderQr().solve(shape);
  return (shape - fit).norm() / shape.norm();
}

// Plates: couples at the rim r^2, a force in the middle r^2 ln r, weight r^4.
TEST(ToleranceOfABend, HoldsHowElseAPlateBends) {
  const Observed observed = Touched();
  const std::vector<Candidate> all = AllCandidates(observed);
  Eigen::VectorXd force(observed.num_rows()), weight(observed.num_rows());
  for (Eigen::Index i = 0; i < force.size(); ++i) {
    const double r = observed.at(i).q_mm.head<2>().norm() / kRim_mm;
    force[i] = r * r * std::log(r);
    weight[i] = std::pow(r, 4);
  }

  constexpr double kRounding = 1e-6;
  EXPECT_LT(Left(observed, Named(all, "bed_bowl"), force), kRounding);
  EXPECT_LT(Left(observed, Named(all, "bed_bowl"), weight), kRounding);
}

// Else one bend could pass for the freedom of another.
TEST(ToleranceOfABend, HoldsNoOtherBend) {
  constexpr double kMostOfIt = 0.9;
  const Observed observed = Touched();
  const std::vector<Candidate> all = AllCandidates(observed);
  const Candidate& bowl = Named(all, "bed_bowl");
  const Candidate& twist = Named(all, "bed_twist");

  EXPECT_GT(Left(observed, bowl, twist.variants.front().columns_mm.col(0)), kMostOfIt);
  EXPECT_GT(Left(observed, twist, bowl.variants.front().columns_mm.col(0)), kMostOfIt);
}

}  // namespace
}  // namespace caltwin
