#include "calibration/diagnosis/covariate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/effects/drive.h"
#include "sim/effects/map_table.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {

double Covariate::Scaled(double value) const {
  return max > min ? std::clamp(2 * (value - min) / (max - min) - 1, -1.0, 1.0) : 0;
}

namespace {

// Whether an axis was told to go to more than one place: of one that was not, a touch's
// place differs by its own reading alone, and would explain itself.
bool IsTold(const Observed& observed, std::size_t axis) {
  constexpr double kApart_mm = 1e-3;
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double told_mm = observed.row(i).cmd_mm[axis];
    if (!Known(told_mm)) continue;
    least_mm = std::min(least_mm, told_mm);
    most_mm = std::max(most_mm, told_mm);
  }
  return most_mm - least_mm > kApart_mm;
}

}  // namespace

std::optional<Covariate> CovariateOf(const Observed& observed, std::string_view word) {
  const bool is_place = word.size() == 1 && word[0] >= 'x' && word[0] <= 'z';
  if (is_place && !IsTold(observed, static_cast<std::size_t>(word[0] - 'x'))) {
    return std::nullopt;
  }
  constexpr std::size_t kMostCounted = 64;
  Covariate covariate{.word = std::string(word),
                      .values = Eigen::VectorXd(observed.num_rows())};
  std::set<double> distinct;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double value = CovariateAt(observed.at(i), word);
    if (!Known(value)) return std::nullopt;
    covariate.values[i] = value;
    if (distinct.size() < kMostCounted) distinct.insert(std::round(value * 1e3) / 1e3);
  }
  covariate.min = covariate.values.minCoeff();
  covariate.max = covariate.values.maxCoeff();
  covariate.num_distinct = static_cast<int>(distinct.size());
  covariate.is_periodic = word == "theta";
  if (covariate.num_distinct < 2) return std::nullopt;
  return covariate;
}

namespace {

double ShowsAtStation(ZReading reading, std::string_view channel) {
  if (reading == ZReading::kGapUnderNozzle) return channel == "gap" ? 1 : 0;
  if (channel == "z") return -1;
  if (channel == "nozzle") return reading == ZReading::kNozzleOnSwitch ? 1 : 0;
  const bool is_bed = reading == ZReading::kProbeOnBed;
  if (channel == "probe") return is_bed ? -1 : 0;
  return channel == "bed" && is_bed ? 1 : 0;
}

}  // namespace

Eigen::VectorXd ChannelOf(const Observed& observed, std::string_view channel) {
  Eigen::VectorXd shows(observed.num_rows());
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const bool is_touch = observed.at(i).kind == RowKind::kTouch;
    if (observed.at(i).station) {
      shows[i] = ShowsAtStation(*observed.at(i).station, channel);
      continue;
    }
    if (const auto drive = DriveNamed(channel)) {
      const At& at = observed.at(i);
      double along = at.n[drive->index];
      if (drive->is_motor) {
        Errors<double> by_one;
        (drive->is_screw ? by_one.screw_mm : by_one.motor_mm)[drive->index] = 1;
        along = at.n.dot(MotionOfMotors_mm(at, by_one));
      }
      shows[i] = observed.MotionSign(i) * along;
    } else if (channel == "probe") {
      shows[i] = is_touch ? -1 : 0;
    } else {
      shows[i] = is_touch ? observed.at(i).n.z() : 0;
    }
  }
  return shows;
}

}  // namespace caltwin
