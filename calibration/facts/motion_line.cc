#include "calibration/facts/motion_line.h"

#include <algorithm>
#include <set>

#include <Eigen/Core>

#include "calibration/facts/one_size.h"
#include "sim/base/dense.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

constexpr double kSure = 4;

// What a line's columns are made of.
struct LineTerms {
  bool has_offset = true, has_slope = true, has_gap = false;
  Eigen::Index num() const {
    return (has_offset ? 1 : 0) + (has_slope ? 1 : 0) + (has_gap ? 1 : 0);
  }
};

// A move, or a distance of two centres, which no wall makes longer.
bool BeginsAtNought(const Row& row) {
  return row.flag == kMoveFlag || row.flag == kDistanceFlag;
}

// Moves begin at nought; readings of one place tell no slope.
LineTerms TermsOf(const Rows& rows, std::size_t axis) {
  std::set<long> places;
  std::set<double> senses;
  bool are_moves = true, is_far = true;
  for (const Row* row : rows) {
    // One size that is a quarter off or more is no surplus.
    constexpr double kFarOff = 0.25;
    is_far &= row->cmd_mm[axis] != 0 &&
              std::abs(row->value_mm) > kFarOff * std::abs(row->cmd_mm[axis]);
    places.insert(std::lround(row->cmd_mm[axis] * 1e3));
    if (Known(row->dir[axis]) && row->dir[axis] != 0) senses.insert(row->dir[axis]);
    are_moves &= BeginsAtNought(*row) && row->cmd_mm[axis] != 0;
  }
  const bool is_one_far = places.size() == 1 && is_far && senses.empty();
  return {.has_offset = !are_moves && !is_one_far,
          .has_slope = places.size() > 1 || are_moves || is_one_far,
          .has_gap = senses.size() > 1};
}

// dof < 0 where there is nothing to fit.
Line FitLine(const Rows& rows, std::size_t axis, LineTerms terms) {
  Line line{.dof = -1, .has_gap = terms.has_gap, .has_slope = terms.has_slope};
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n < terms.num() || (!terms.has_slope && !terms.has_gap)) return line;
  line.are_moves = BeginsAtNought(*rows.front());
  line.are_parts = AreSizes(rows);
  line.has_senses_unknown = std::ranges::none_of(rows, [&](const Row* row) {
    return Known(row->dir[axis]) && row->dir[axis] != 0;
  });
  Eigen::MatrixXd columns(n, terms.num());
  Eigen::VectorXd values(n);
  double mid_mm = 0;
  for (const Row* row : rows) {
    if (terms.has_offset) mid_mm += row->cmd_mm[axis] / static_cast<double>(n);
    line.least_mm = std::min(line.least_mm, row->cmd_mm[axis]);
    line.most_mm = std::max(line.most_mm, row->cmd_mm[axis]);
  }
  const Eigen::Index slope_at = terms.has_offset ? 1 : 0;
  const Eigen::Index gap_at = slope_at + (terms.has_slope ? 1 : 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Row& row = *rows[static_cast<std::size_t>(i)];
    const double n_axis = row.n[axis] < 0 ? -1 : 1;
    if (terms.has_offset) columns(i, 0) = 1;
    if (terms.has_slope) columns(i, slope_at) = row.cmd_mm[axis] - mid_mm;
    if (terms.has_gap)
      columns(i, gap_at) = Known(row.dir[axis]) ? -row.dir[axis] / 2 : 0;
    values[i] = row.value_mm * n_axis;
  }
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  if (EigenvaluesOf(normal)[0] < 1e-12 * normal.trace()) return line;
  const Cholesky solver(normal);
  const Eigen::VectorXd sizes = solver.Solve(columns.transpose() * values);
  const Eigen::VectorXd sds =
      solver.SolveEach(Eigen::MatrixXd::Identity(terms.num(), terms.num()))
          .diagonal()
          .cwiseSqrt();
  if (terms.has_slope) {
    line.slope = sizes[slope_at];
    line.slope_unit_sd = sds[slope_at];
  }
  if (terms.has_offset) {
    line.offset_mm = sizes[0] - line.slope * mid_mm;
    line.offset_unit_sd = std::hypot(sds[0], line.slope_unit_sd * mid_mm);
  }
  if (terms.has_gap) {
    line.gap_mm = sizes[gap_at];
    line.gap_unit_sd = sds[gap_at];
  }
  line.left_mm2 = (values - columns * sizes).squaredNorm();
  line.dof = static_cast<double>(n - terms.num());
  return line;
}

// Moves begin at nought, unless what is missing of them is the same of every length.
Line FitLine(const Rows& rows, std::size_t axis) {
  constexpr std::size_t kFewestPlaces = 3;
  LineTerms terms = TermsOf(rows, axis);
  std::set<long> places;
  for (const Row* row : rows) places.insert(std::lround(row->cmd_mm[axis] * 1e3));
  if (terms.has_offset || places.size() < kFewestPlaces)
    return FitLine(rows, axis, terms);
  terms.has_offset = true;
  const Line with = FitLine(rows, axis, terms);
  if (with.dof >= 1) {
    const double sd_mm = std::sqrt(with.left_mm2 / with.dof) * with.offset_unit_sd;
    if (std::abs(with.offset_mm) > kSure * sd_mm && sd_mm > 0) return with;
  }
  terms.has_offset = false;
  return FitLine(rows, axis, terms);
}

// Without rows that went less far since they turned round than what is lost there: the
// play takes up part of them only.
Rows BeyondGap(const Rows& rows, std::size_t axis, double gap_mm) {
  constexpr double kClear = 1.2;
  Rows beyond;
  double turned_at_mm = kUnknown;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = *rows[i];
    const bool turns = i > 0 && row.dir[axis] != rows[i - 1]->dir[axis];
    if (i == 0 || turns) turned_at_mm = i > 0 ? rows[i - 1]->cmd_mm[axis] : kUnknown;
    const double went_mm = std::abs(row.cmd_mm[axis] - turned_at_mm);
    const bool is_clear = !Known(went_mm) || went_mm > kClear * std::abs(gap_mm);
    if (is_clear && Known(turned_at_mm)) beyond.push_back(&row);
  }
  return beyond;
}

}  // namespace

Line FitBeyondGap(const Rows& rows, std::size_t axis) {
  constexpr int kRounds = 3;
  Line line = FitLine(rows, axis);
  for (int round = 0; round < kRounds && line.has_gap && line.dof >= 1; ++round) {
    const Rows beyond = BeyondGap(rows, axis, line.gap_mm);
    // Targets that are far apart lose nothing of it.
    constexpr std::size_t kFewest = 6;
    if (beyond.size() < kFewest || 2 * beyond.size() < rows.size()) break;
    const Line refined = FitLine(beyond, axis);
    if (!refined.has_gap || refined.dof < 1) break;
    const bool is_better =
        refined.left_mm2 / refined.dof < line.left_mm2 / line.dof / 2;
    if (!is_better) break;
    line = refined;
  }
  return line;
}

double NoiseOf_mm(const Line& line, const ReadingNoise& noise) {
  constexpr double kFewest = 2, kNothing_mm = 1e-6;
  double left_mm = line.dof >= kFewest ? std::sqrt(line.left_mm2 / line.dof) : kUnknown;
  if (left_mm < kNothing_mm) left_mm = kUnknown;
  if (!Known(noise.sd_mm)) return left_mm;
  return Known(left_mm) ? std::max(noise.sd_mm, left_mm) : noise.sd_mm;
}

}  // namespace caltwin
