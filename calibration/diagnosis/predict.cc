#include "calibration/diagnosis/predict.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/outliers.h"
#include "calibration/facts/fact.h"
#include "sim/base/dense.h"

namespace caltwin {
namespace {

// Where things lie and stand, anew in every run; the rest is the machine's.
bool IsPlacement(std::string_view name) {
  return name.starts_with("placement.") || name.starts_with("face.") ||
         name.starts_with("bed_plane") || name.starts_with("tracker_frame");
}

// What is left of the rows, placements fitted, the machine's lines held.
Eigen::VectorXd LeftOf(const Observed& observed,
                       const std::map<std::string, double>& baseline,
                       const std::vector<bool>& out) {
  Eigen::VectorXd left_mm = observed.residual_mm();
  std::vector<Nuisance> free;
  for (const Nuisance& line : BaselineOf(observed)) {
    if (IsPlacement(line.name)) {
      free.push_back(line);
      continue;
    }
    const auto held = baseline.find(line.name);
    if (held != baseline.end())
      left_mm -= line.column_mm * (held->second - line.offset);
  }
  const auto num = static_cast<Eigen::Index>(free.size());
  if (num == 0) return left_mm;
  // The same weak pull to the drawing as in a diagnosis, in units of a micrometre.
  constexpr double kWeight_per_mm = 1e3;
  Eigen::MatrixXd columns(left_mm.size() + num, num);
  Eigen::VectorXd right(left_mm.size() + num);
  columns.setZero();
  right.setZero();
  for (Eigen::Index k = 0; k < num; ++k) {
    const Nuisance& line = free[static_cast<std::size_t>(k)];
    columns.col(k).head(left_mm.size()) =
        line.column_mm * kWeight_per_mm * line.prior_sd;
    columns(left_mm.size() + k, k) = 1;
  }
  right.head(left_mm.size()) = left_mm * kWeight_per_mm;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!out[i]) continue;
    columns.row(static_cast<Eigen::Index>(i)).setZero();
    right[static_cast<Eigen::Index>(i)] = 0;
  }
  const Eigen::VectorXd sizes = QrOf(columns).Solve(right);
  for (Eigen::Index k = 0; k < num; ++k) {
    const Nuisance& line = free[static_cast<std::size_t>(k)];
    left_mm -= line.column_mm * line.prior_sd * sizes[k];
  }
  return left_mm;
}

// Rows that are bad by themselves, whatever the model: alone far from all others, or
// from the repeats of their place.
std::vector<bool> BadRows(const Observed& observed, const Facts& facts) {
  std::vector<bool> out = LoneRows(observed);
  for (const Fact& fact : facts.all) {
    if (fact.id != "outliers") continue;
    for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
      if (std::ranges::find(fact.rows, observed.row(i).row) != fact.rows.end())
        out[static_cast<std::size_t>(i)] = true;
    }
  }
  return out;
}

bool IsSamePlace(const Row& one, const Row& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    const bool is_same = one.cmd_mm[k] == other.cmd_mm[k] ||
                         (!Known(one.cmd_mm[k]) && !Known(other.cmd_mm[k]));
    if (!is_same || one.dir[k] * other.dir[k] < 0) return false;
  }
  return one.feature == other.feature && one.home == other.home;
}

// Of readings of one place, one straight after the other: whatever drifts has not gone
// far between them. kUnknown: too few.
double StepToStep_mm(const Observed& observed, const std::vector<bool>& out) {
  constexpr double kFewest = 10;
  double squares = 0, num = 0;
  for (Eigen::Index i = 1; i < observed.num_rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Row &before = observed.row(i - 1), &now = observed.row(i);
    if (out[at] || out[at - 1] || !IsSamePlace(before, now)) continue;
    squares += std::pow(now.value_mm - before.value_mm, 2);
    num += 1;
  }
  return num >= kFewest ? std::sqrt(squares / num / 2) : kUnknown;
}

// Of repeats; kUnknown: nothing was measured again.
double Floor_mm(const Observed& observed, const std::vector<bool>& out) {
  constexpr int kFewestRepeats = 3;
  const PureError pure = RepeatsOf(observed, kFewestRepeats);
  double squares = 0, dof = 0;
  for (std::size_t c = 0; c < pure.sigma_mm.size(); ++c) {
    if (!Known(pure.sigma_mm[c])) continue;
    squares += pure.dof[c] * pure.sigma_mm[c] * pure.sigma_mm[c];
    dof += pure.dof[c];
  }
  const double repeats_mm = dof > 0 ? std::sqrt(squares / dof) : kUnknown;
  const double step_mm = StepToStep_mm(observed, out);
  if (!Known(step_mm)) return repeats_mm;
  return Known(repeats_mm) ? std::min(step_mm, repeats_mm) : step_mm;
}

double Rms_mm(const Eigen::VectorXd& left_mm, const std::vector<bool>& out) {
  double sum = 0, num = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i]) continue;
    sum += std::pow(left_mm[static_cast<Eigen::Index>(i)], 2);
    num += 1;
  }
  return std::sqrt(sum / std::max(num, 1.0));
}

}  // namespace

Prediction Predict(const Observed& without,
                   const Observed& with,
                   const std::map<std::string, double>& baseline) {
  constexpr double kTransfers = 2.0 / 3;
  const Facts facts = FactsOf(without.table(), without.header());
  const std::vector<bool> out = BadRows(without, facts);
  Prediction prediction{.before_mm = Rms_mm(LeftOf(without, baseline, out), out),
                        .after_mm = Rms_mm(LeftOf(with, baseline, out), out),
                        .floor_mm = Floor_mm(without, out),
                        .rows = static_cast<int>(without.num_rows()),
                        .left_out = static_cast<int>(std::ranges::count(out, true))};
  prediction.transfers = prediction.after_mm < kTransfers * prediction.before_mm;
  return prediction;
}

}  // namespace caltwin
