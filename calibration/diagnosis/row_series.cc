#include "calibration/diagnosis/row_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include <Eigen/Dense>

#include "sim/base/median.h"

namespace caltwin {
namespace {

constexpr double kOutlying = 5;
constexpr int kNumTerms = 5;  // Offset, x, y, z, sense.
using Terms = Eigen::Matrix<double, kNumTerms, 1>;
using NormalMatrix = Eigen::Matrix<double, kNumTerms, kNumTerms>;

long Thousandths(double number) {
  return Known(number) ? std::lround(1000 * number) : 0;
}

/// The terms of a row, positions from the series' first row, so that they are of order
/// the travel.
Terms TermsOf(const Row& row, const Row& origin) {
  Terms terms = Terms::Zero();
  terms[0] = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double step_mm = row.cmd_mm[axis] - origin.cmd_mm[axis];
    terms[1 + axis] = Known(step_mm) ? step_mm : 0;
  }
  terms[4] = SenseAlongNormal(row);
  return terms;
}

}  // namespace

std::vector<RowSeries> SeriesOf(const RowTable& table) {
  using Key =
      std::tuple<std::string, RowKind, std::string, std::string, std::array<long, 3>>;
  std::map<Key, RowSeries> series;
  for (const Row& row : table.rows) {
    const std::array<long, 3> n = {
        Thousandths(row.n[0]), Thousandths(row.n[1]), Thousandths(row.n[2])};
    RowSeries& here = series[{row.campaign, row.kind, row.setup, row.feature, n}];
    if (here.first == nullptr) here.first = &row;
    here.rows.push_back(&row);
  }
  std::vector<RowSeries> all;
  for (auto& [key, one] : series) all.push_back(std::move(one));
  return all;
}

double AlongNormal_mm(const Row& row) {
  double along_mm = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (Known(row.cmd_mm[axis]) && Known(row.n[axis])) {
      along_mm += row.cmd_mm[axis] * row.n[axis];
    }
  }
  return along_mm;
}

double SenseAlongNormal(const Row& row) {
  for (int axis = 0; axis < 3; ++axis) {
    if (Known(row.n[axis]) && std::abs(row.n[axis]) > 0.99 && Known(row.dir[axis])) {
      return row.dir[axis] * (row.n[axis] > 0 ? 1 : -1);
    }
  }
  return 0;
}

SeriesFit FitSeries(const RowSeries& series) {
  SeriesFit fit;
  std::vector<bool> is_used(series.rows.size(), true);
  std::vector<double> sizes_mm(series.rows.size());
  for (int pass = 0; pass < 2; ++pass) {
    NormalMatrix normal = NormalMatrix::Zero();
    Terms right = Terms::Zero();
    for (std::size_t i = 0; i < series.rows.size(); ++i) {
      if (!is_used[i]) continue;
      const Terms terms = TermsOf(*series.rows[i], *series.first);
      normal += terms * terms.transpose();
      right += terms * series.rows[i]->value_mm;
    }
    // A ridge of a billionth of each term's own size: terms that do not vary, and those
    // that repeat another, get nothing.
    const Terms ridge = 1e-9 * normal.diagonal().array() + 1e-12;
    normal.diagonal() += ridge;
    const Eigen::LDLT<NormalMatrix> solver{normal};
    const Terms terms = solver.solve(right);
    for (std::size_t i = 0; i < series.rows.size(); ++i) {
      sizes_mm[i] = std::abs(series.rows[i]->value_mm -
                             terms.dot(TermsOf(*series.rows[i], *series.first)));
    }
    const double median_mm = Median(sizes_mm);
    fit.size_mm = kSigmaOfMedian * median_mm;
    for (std::size_t i = 0; i < sizes_mm.size(); ++i) {
      is_used[i] = sizes_mm[i] <= kOutlying * median_mm;
    }
    fit.slope = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double n = series.first->n[axis];
      if (Known(n)) fit.slope += terms[1 + axis] * n;
    }
    const double variance = solver.solve(Terms::Unit(4))[4];
    const bool has_both = normal(4, 4) - normal(0, 4) * normal(0, 4) / normal(0, 0) > 1;
    fit.half_gap_mm = has_both ? terms[4] : 0;
    fit.half_gap_sd_mm =
        has_both ? fit.size_mm * std::sqrt(std::max(variance, 0.0)) : 0;
  }
  return fit;
}

double RepeatDeviation_mm(const std::vector<RowSeries>& all) {
  double square = 0;
  double dof = 0;
  bool is_repeated = false;
  for (const RowSeries& series : all) {
    // At a printer's station repeats are also equally warm, to 1 K, and of one homing.
    using Pose = std::tuple<std::array<double, 3>, double, long, std::string, bool>;
    std::map<Pose, std::vector<double>> at_pose;
    for (const Row* row : series.rows) {
      std::array<double, 3> pose_mm = row->cmd_mm;
      for (double& number : pose_mm) number = Known(number) ? number : 0;
      const bool is_heated = Known(row->temp_nozzle_c);
      const long warm_c = is_heated ? std::lround(row->temp_nozzle_c) : 0;
      at_pose[{pose_mm,
               SenseAlongNormal(*row),
               warm_c,
               is_heated ? row->home : "",
               row->nozzle_wiped == 1}]
          .push_back(row->value_mm);
    }
    for (const auto& [pose, values_mm] : at_pose) {
      double sum = 0;
      for (const double value : values_mm) sum += value;
      const double count = static_cast<double>(values_mm.size());
      for (const double value : values_mm) square += std::pow(value - sum / count, 2);
      dof += count - 1;
      is_repeated = is_repeated || values_mm.size() >= 3;
    }
  }
  return is_repeated && dof > 0 ? std::sqrt(square / dof) : kUnknown;
}

}  // namespace caltwin
