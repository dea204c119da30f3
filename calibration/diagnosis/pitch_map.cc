#include "calibration/diagnosis/pitch_map.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// Distinct commanded positions of the rows that the axis shows in.
std::vector<double> PositionsOf(const Observed& observed, int axis) {
  std::vector<double> positions_mm;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double cmd_mm = observed.row(i).cmd_mm[static_cast<std::size_t>(axis)];
    if (Known(cmd_mm) && std::abs(observed.at(i).n[axis]) > 0.5) {
      positions_mm.push_back(std::round(cmd_mm * 1e4) / 1e4);
    }
  }
  std::ranges::sort(positions_mm);
  const auto repeated = std::ranges::unique(positions_mm);
  positions_mm.erase(repeated.begin(), repeated.end());
  return positions_mm;
}

// Positions that stand at all phases of a wave, or closely enough along it.
bool SeesWave(const std::vector<double>& positions_mm, double period_mm) {
  constexpr double kPerPeriod = 2.5;
  constexpr double kMostAligned = 0.5;
  std::complex<double> sum = 0;
  for (const double q_mm : positions_mm) {
    sum += std::polar(1.0, 2 * std::numbers::pi * q_mm / period_mm);
  }
  const auto num = static_cast<double>(positions_mm.size());
  const double span_mm = positions_mm.back() - positions_mm.front();
  return std::abs(sum) / num < kMostAligned ||
         num * period_mm / std::max(span_mm, 1e-9) >= kPerPeriod;
}

// Half the positions must not stand on a grid that hides a wave between them.
bool SeesAllWaves(const Observed& observed, Axis axis) {
  constexpr std::size_t kFewest = 5;
  const auto positions_mm = PositionsOf(observed, Index(axis));
  if (positions_mm.size() < kFewest) return false;
  // A machine that was only assumed has no periods to rule out.
  if (observed.machine().file.empty() &&
      !observed.header().transmission.contains(Name(axis))) {
    return false;
  }
  const AxisDrawing& drawing = observed.machine().axis(axis);
  const double microstep_mm = 4 * drawing.lead_mm / drawing.full_steps_per_rev;
  return SeesWave(positions_mm, drawing.lead_mm) &&
         SeesWave(positions_mm, microstep_mm);
}

// Part of the variance of rows left out that the findings explain.
double Explained(const HeldOut& held) {
  return 1 - std::pow(held.after_mm / std::max(held.before_mm, 1e-300), 2);
}

}  // namespace

bool IsPitchMap(const Observed& observed,
                const Candidate& candidate,
                const GainFigures& gain) {
  constexpr double kHolds = 0.8;
  const auto axis = AxisNamed(candidate.shown.channel);
  // Elsewhere motors have no axis of their own.
  if (!observed.machine().kind->axes_are_drives()) return false;
  if (!candidate.is_free() || !axis || candidate.shown.covariates.size() != 1 ||
      candidate.shown.covariates[0] != candidate.shown.channel) {
    return false;
  }
  if (!SeesAllWaves(observed, *axis)) return false;
  // Where no position was measured twice, leaving rows out leaves positions out.
  if (gain.positions_as_fitted.groups == 0 || gain.runs.groups == 0) {
    return Explained(gain.blocks) > 0;
  }
  return Explained(gain.positions_as_fitted) >= kHolds * Explained(gain.runs);
}

}  // namespace caltwin
