#include "calibration/diagnosis/rounding.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/noise.h"

namespace caltwin {

double RoundingSigma_mm(const Observed& observed, Eigen::Index i) {
  const auto stated = observed.header().settings.find(observed.row(i).settings);
  if (!observed.at(i).delta || stated == observed.header().settings.end()) return 0;
  double variance_mm2 = 0;
  for (int tower = 0; tower < kNumTowers; ++tower) {
    const auto steps = stated->second.steps_per_mm.find(TowerName(tower));
    if (steps == stated->second.steps_per_mm.end() || steps->second <= 0) continue;
    const double slope =
        observed.at(i).n.dot(observed.at(i).delta->by_knob.col(kEndstopKnob + tower));
    variance_mm2 += std::pow(slope / steps->second, 2) / 12.0;
  }
  return std::sqrt(variance_mm2);
}

namespace {

constexpr double kNoSwitch_mm = 1e-4;  // No switch of a printer repeats to better.

// How many count the same at one place, as a reading finds it in the mean.
double AlikeOf(const Observed& observed, const std::vector<Eigen::Index>& rows) {
  constexpr double kSame_mm = 1e-6;
  std::map<std::string, double> counts;
  for (const Eigen::Index i : rows) {
    const Row& row = observed.row(i);
    ++counts[fmt::format("{}|{:.3f}|{:.3f}|{}",
                         row.feature,
                         row.cmd_mm[0],
                         row.cmd_mm[1],
                         std::llround(row.value_mm / kSame_mm))];
  }
  double squares = 0;
  for (const auto& [key, count] : counts) squares += count * count;
  return squares / static_cast<double>(rows.size());
}

// By repeats; 0 where there are few.
double Scatter_mm(const Observed& observed, Eigen::Index row) {
  constexpr int kEnough = 10;
  const auto campaign =
      static_cast<std::size_t>(observed.campaign_of()[static_cast<std::size_t>(row)]);
  const double sigma_mm = RepeatsOf(observed, kEnough).sigma_mm[campaign];
  return Known(sigma_mm) ? sigma_mm : 0;
}

}  // namespace

double CountedSigma_mm(const Observed& observed, const std::string& campaign) {
  const Machine& machine = observed.machine();
  if (!machine.z_station && !machine.triple_z) return 0;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const bool is_touch = observed.at(i).kind == RowKind::kTouch;
    if (is_touch && observed.row(i).campaign == campaign) rows.push_back(i);
  }
  const double least_mm = machine.z_station ? kNoSwitch_mm : 0;
  if (rows.empty()) return least_mm;
  const double step_mm = 1 / machine.axis(Axis::kZ).steps_per_mm();
  const double carried =
      2 * std::numbers::pi * Scatter_mm(observed, rows.front()) / step_mm;
  const double in_common = (AlikeOf(observed, rows) - 1) * std::exp(-carried * carried);
  return std::max(least_mm, step_mm / std::sqrt(12.0)) * std::sqrt(1 + in_common);
}

double RoundedBy_mm(const Observed& observed, Eigen::Index i, Axis axis) {
  constexpr double kNothing_mm = 1e-9;
  const At& at = observed.at(i);
  const auto stated = observed.header().settings.find(observed.row(i).settings);
  const bool counts_axes = !observed.machine().delta && !observed.machine().triple_z;
  if (!counts_axes || at.kind != RowKind::kPosition ||
      stated == observed.header().settings.end()) {
    return 0;
  }
  const auto steps = stated->second.steps_per_mm.find(Name(axis));
  if (steps == stated->second.steps_per_mm.end() || steps->second <= 0) return 0;
  const double command_mm =
      observed.row(i).cmd_mm[static_cast<std::size_t>(Index(axis))];
  const double beyond_mm =
      std::round(command_mm * steps->second) / steps->second - command_mm;
  return std::abs(beyond_mm) > kNothing_mm ? beyond_mm : 0;
}

}  // namespace caltwin
