#include "calibration/facts/sheet.h"

#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "sim/base/dense.h"
#include "sim/base/median.h"
#include "sim/base/rng.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

// The smallest half of squared distances from what passes through `chosen`; none where
// those do not determine it.
std::optional<std::pair<double, Eigen::VectorXd>> TrimmedBy(
    const Eigen::MatrixXd& columns,
    const Eigen::VectorXd& heights_mm,
    const std::vector<Eigen::Index>& chosen,
    Eigen::Index half) {
  Eigen::MatrixXd own(static_cast<Eigen::Index>(chosen.size()), columns.cols());
  Eigen::VectorXd right(own.rows());
  for (Eigen::Index k = 0; k < own.rows(); ++k) {
    own.row(k) = columns.row(chosen[static_cast<std::size_t>(k)]);
    right[k] = heights_mm[chosen[static_cast<std::size_t>(k)]];
  }
  const Eigen::VectorXd sizes = LeastSquares(own, right);
  if (!sizes.allFinite() || (own * sizes - right).cwiseAbs().maxCoeff() > 1e-6) {
    return std::nullopt;
  }
  const Eigen::VectorXd left = heights_mm - columns * sizes;
  std::vector<double> squares(left.size());
  for (Eigen::Index i = 0; i < left.size(); ++i) {
    squares[static_cast<std::size_t>(i)] = left[i] * left[i];
  }
  std::ranges::nth_element(squares, squares.begin() + half);
  const double sum = std::accumulate(squares.begin(), squares.begin() + half, 0.0);
  return std::pair{sum, left};
}

}  // namespace

SheetFit Fit(const Sheet& sheet, Eigen::Index terms) {
  const Eigen::MatrixXd columns = sheet.Columns(terms);
  const Eigen::VectorXd heights_mm = sheet.Heights_mm();
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  SheetFit fit;
  if (sheet.size() < terms || EigenvaluesOf(normal)[0] < 1e-6 * normal.trace())
    return fit;
  const Cholesky solver(normal);
  fit.is_determined = true;
  fit.sizes_mm = solver.Solve(columns.transpose() * heights_mm);
  fit.unit_sds =
      solver.SolveEach(Eigen::MatrixXd::Identity(terms, terms)).diagonal().cwiseSqrt();
  fit.left_mm = heights_mm - columns * fit.sizes_mm;
  fit.dof = static_cast<double>(sheet.size() - terms);
  return fit;
}

std::vector<bool> FarSpots(const Sheet& sheet, double noise_mm) {
  constexpr Eigen::Index kFewest = 7, kFewestForShape = 15;
  constexpr int kDraws = 400;
  constexpr double kFar = 8, kMostShare = 0.2, kLeast_mm = 0.03;
  const Eigen::Index n = sheet.size();
  std::vector<bool> is_out(static_cast<std::size_t>(n), false);
  if (n < kFewest) return is_out;
  const Eigen::Index terms = n >= kFewestForShape ? kAllTerms : kPlaneTerms;
  const Eigen::MatrixXd columns = sheet.Columns(terms);
  const Eigen::VectorXd heights_mm = sheet.Heights_mm();
  const Eigen::Index half = (n + terms + 1) / 2;
  Rng rng(1, 0, "facts.surface");
  std::optional<std::pair<double, Eigen::VectorXd>> best;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  for (int draw = 0; draw < kDraws; ++draw) {
    for (Eigen::Index k = 0; k < terms; ++k) {
      const auto other =
          k + static_cast<Eigen::Index>(rng.Uniform() * static_cast<double>(n - k));
      std::swap(order[static_cast<std::size_t>(k)],
                order[static_cast<std::size_t>(std::min(other, n - 1))]);
    }
    const std::vector<Eigen::Index> chosen(order.begin(), order.begin() + terms);
    auto tried = TrimmedBy(columns, heights_mm, chosen, half);
    if (tried && (!best || tried->first < best->first)) best = std::move(tried);
  }
  if (!best) return is_out;
  std::vector<double> sizes_mm;
  for (const double left_mm : best->second) sizes_mm.push_back(std::abs(left_mm));
  // Half of the spots fit their own surface too well.
  const double spread_mm =
      kSigmaOfMedian * Median(sizes_mm) * (1 + 5.0 / static_cast<double>(n - terms));
  const double limit_mm =
      std::max({kFar * spread_mm, Known(noise_mm) ? kFar * noise_mm : 0, kLeast_mm});
  Eigen::Index num_out = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    is_out[static_cast<std::size_t>(i)] = std::abs(best->second[i]) > limit_mm;
    num_out += is_out[static_cast<std::size_t>(i)] ? 1 : 0;
  }
  const auto most = std::max<Eigen::Index>(
      1, static_cast<Eigen::Index>(kMostShare * static_cast<double>(n)));
  if (num_out > most) is_out.assign(is_out.size(), false);
  return is_out;
}

std::map<std::string, std::vector<Spot>> SheetsOf(const std::vector<const Row*>& rows,
                                                  const std::set<std::int64_t>& out) {
  constexpr double kUp = 0.999;
  std::map<std::string, std::map<std::pair<long, long>, Spot>> sheets;
  for (const Row* row : rows) {
    const bool is_height = row->kind == RowKind::kTouch && row->n[2] > kUp &&
                           Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]);
    // Motors moved one by one raise what is touched.
    if (!is_height || out.contains(row->row) || row->flag == kReleaseFlag) continue;
    std::string key =
        row->campaign + "|" + row->setup + "|" + row->feature + "|" + row->home;
    if (Known(row->cmd_mm[2])) key += fmt::format("|{:.3f}", row->cmd_mm[2]);
    Spot& spot = sheets[key][{std::lround(row->cmd_mm[0] * 100),
                              std::lround(row->cmd_mm[1] * 100)}];
    spot.x_mm = row->cmd_mm[0];
    spot.y_mm = row->cmd_mm[1];
    spot.height_mm += row->value_mm;
    spot.num += 1;
    spot.rows.push_back(row->row);
  }
  std::map<std::string, std::vector<Spot>> all;
  for (auto& [key, spots] : sheets) {
    for (auto& [at, spot] : spots) {
      spot.height_mm /= spot.num;
      all[key].push_back(spot);
    }
  }
  return all;
}

SpotNoise NoiseOf(const Sheet& sheet, const SheetFit& fit, const ReadingNoise& noise) {
  constexpr double kFewest = 3, kStatedDof = 10;
  if (Known(noise.sd_mm)) {
    return {noise.sd_mm / std::sqrt(sheet.MeanReadings()),
            noise.is_stated ? kStatedDof : noise.dof};
  }
  if (fit.dof >= kFewest) return {std::sqrt(fit.squares_mm2() / fit.dof), fit.dof};
  return {};
}

}  // namespace caltwin
