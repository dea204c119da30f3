#include "calibration/kinds/triple_z/plane.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/touch_noise.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

double BedPlane::TiltX_deg() const {
  return DegFromRad(std::atan(a()));
}
double BedPlane::TiltY_deg() const {
  return DegFromRad(std::atan(b()));
}
double BedPlane::Tilt_deg() const {
  return DegFromRad(std::atan(std::hypot(a(), b())));
}

BedPlane FitBedPlane(std::span<const BedTouch> touches,
                     double sigma_mm,
                     bool is_sigma_stated) {
  std::vector<Vec3<double>> points_mm;
  for (const BedTouch& touch : touches) {
    points_mm.emplace_back(touch.at_mm[0], touch.at_mm[1], touch.height_mm);
  }
  const TiltPlane first = FitTiltPlane(points_mm, sigma_mm);
  // Where the touches scatter more than was said, they are believed.
  const double factor = ScatterFactor(first.chi2_per_dof, first.dof, is_sigma_stated);
  BedPlane plane{.fit = factor > 1 ? FitTiltPlane(points_mm, factor * sigma_mm) : first,
                 .points = static_cast<int>(touches.size())};
  for (Uncertain* slope : {&plane.fit.slope_x, &plane.fit.slope_y}) {
    Given readings{.sd = slope->sd};
    if (factor > 1) readings.dof = first.dof;
    slope->budget = {InputOf("touches", 1, readings)};
  }
  return plane;
}

Vec3<double> ScrewOffsets_mm(const BedPlane& plane,
                             const Pivots<double>& pivots_mm,
                             double level_mm,
                             OffsetRule rule) {
  Vec3<double> offsets_mm;
  for (int i = 0; i < kNumScrews; ++i) {
    const double z_mm = plane.At_mm(pivots_mm[static_cast<std::size_t>(i)]);
    offsets_mm[i] = rule == OffsetRule::kExample ? z_mm : level_mm - z_mm;
  }
  if (rule == OffsetRule::kLevel) {
    return offsets_mm;
  }
  return offsets_mm.array() - offsets_mm.minCoeff();
}

LevelReport ReportLevel(std::span<const BedTouch> touches, double level_mm) {
  LevelReport report{.count = static_cast<int>(touches.size())};
  if (touches.empty()) return report;
  double squares = 0;
  for (const BedTouch& touch : touches) {
    const double off_mm = std::abs(touch.height_mm - level_mm);
    report.mean_mm += off_mm / report.count;
    report.max_mm = std::max(report.max_mm, off_mm);
    squares += off_mm * off_mm / report.count;
  }
  report.std_mm = std::sqrt(std::max(0.0, squares - report.mean_mm * report.mean_mm));
  return report;
}

std::vector<std::string> PlaneVerdicts(const BedPlane& plane) {
  std::vector<std::string> verdicts;
  if (!plane.is_told()) {
    verdicts.push_back(
        "these points do not span a plane: probe at three places that are not on a "
        "line");
    return verdicts;
  }
  if (plane.fit.dof == 0) {
    verdicts.push_back(
        "three points fit any plane exactly: a residual of 0 says nothing; four and "
        "more "
        "tell how flat the bed is");
  }
  return verdicts;
}

}  // namespace caltwin
