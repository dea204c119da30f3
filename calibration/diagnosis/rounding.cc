#include "calibration/diagnosis/rounding.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/noise.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

double RoundingSigma_mm(const Observed& observed, Eigen::Index i) {
  return DiagnosedAs(observed.machine()).Rounding_mm(observed, i);
}

namespace {

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

// As the rows' header or the machine file says; 0: nobody does.
double StatedSteps_per_mm(const Observed& observed, Eigen::Index i, int drive) {
  const Machine& machine = observed.machine();
  const auto& all = observed.header().settings;
  const auto stated = all.find(observed.row(i).settings);
  if (stated != all.end()) {
    const auto steps =
        stated->second.steps_per_mm.find(DriveName(machine.kind->drive_map(), drive));
    if (steps != stated->second.steps_per_mm.end()) return steps->second;
  }
  if (machine.file.empty()) return 0;
  return machine.settings.steps_per_mm[static_cast<std::size_t>(drive)];
}

}  // namespace

double CountedSigma_mm(const Observed& observed, const std::string& campaign) {
  const Machine& machine = observed.machine();
  const std::optional<double> least = DiagnosedAs(machine).LeastCounted_mm();
  if (!least) return 0;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const bool is_touch = observed.at(i).kind == RowKind::kTouch;
    if (is_touch && observed.row(i).campaign == campaign) rows.push_back(i);
  }
  if (rows.empty()) return *least;
  const double step_mm = 1 / machine.axis(Axis::kZ).steps_per_mm();
  const double carried =
      2 * std::numbers::pi * Scatter_mm(observed, rows.front()) / step_mm;
  const double in_common = (AlikeOf(observed, rows) - 1) * std::exp(-carried * carried);
  return std::max(*least, step_mm / std::sqrt(12.0)) * std::sqrt(1 + in_common);
}

double RoundedBy_mm(const Observed& observed, Eigen::Index i, int drive) {
  constexpr double kNothing_mm = 1e-9;
  const At& at = observed.at(i);
  const DriveMap* drives = observed.machine().kind->drive_map();
  const bool counts_axes =
      drives != nullptr || observed.machine().kind->motors().empty();
  const double steps_per_mm = StatedSteps_per_mm(observed, i, drive);
  // A touch ends where the surface is; on a circle each point has its own steps.
  if (!counts_axes || at.kind == RowKind::kTouch || !(steps_per_mm > 0)) return 0;
  const auto& cmd_mm = observed.row(i).cmd_mm;
  const double command_mm = DrivesOf(drives, {cmd_mm[0], cmd_mm[1], cmd_mm[2]})[drive];
  const double beyond_mm =
      std::round(command_mm * steps_per_mm) / steps_per_mm - command_mm;
  return std::abs(beyond_mm) > kNothing_mm ? beyond_mm : 0;
}

}  // namespace caltwin
