#include "sim/machine/kinds/delta/touch.h"

#include <cmath>
#include <limits>
#include <vector>

#include "sim/machine/kinds/delta/mesh.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

// Of a square lattice an eighth of the radius wide, the 197 points on the disc.
std::vector<Vec3<double>> OnDisc(double radius_mm) {
  constexpr int kSteps = 8;
  std::vector<Vec3<double>> points;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j > kSteps * kSteps) continue;
      points.emplace_back(radius_mm * i / kSteps, radius_mm * j / kSteps, 0);
    }
  }
  return points;
}

// The shift, turn and scale that map commanded to moved best; what they leave.
void AddPlane(const std::vector<Vec3<double>>& commanded,
              const std::vector<Vec3<double>>& moved,
              DeltaAccuracy* accuracy) {
  const auto num = static_cast<double>(commanded.size());
  Vec3<double> from = Vec3<double>::Zero(), to = Vec3<double>::Zero();
  for (std::size_t i = 0; i < commanded.size(); ++i) {
    from += commanded[i] / num;
    to += moved[i] / num;
  }
  double along = 0, turned = 0, square = 0;
  for (std::size_t i = 0; i < commanded.size(); ++i) {
    const Vec3<double> p = commanded[i] - from, q = moved[i] - to;
    along += p[0] * q[0] + p[1] * q[1];
    turned += p[0] * q[1] - p[1] * q[0];
    square += p[0] * p[0] + p[1] * p[1];
  }
  const double turn_rad = std::atan2(turned, along);
  accuracy->xy_scale = std::hypot(along, turned) / square - 1;
  double left2 = 0;
  for (std::size_t i = 0; i < commanded.size(); ++i) {
    const Vec3<double> p = commanded[i] - from, q = moved[i] - to;
    const double x = std::cos(turn_rad) * p[0] - std::sin(turn_rad) * p[1];
    const double y = std::sin(turn_rad) * p[0] + std::cos(turn_rad) * p[1];
    left2 += std::pow(q[0] - x, 2) + std::pow(q[1] - y, 2);
  }
  accuracy->xy_rms_mm = std::sqrt(left2 / num);
}

}  // namespace

std::optional<double> DeltaTouchHeight_mm(const DeltaBuild<double>& build,
                                          const DeltaBed<double>& bed,
                                          const DeltaDescent& descent,
                                          double near_mm,
                                          const DeltaTip& tip) {
  constexpr int kMostRounds = 50;
  constexpr double kThere_mm = 1e-10;
  double z_mm = near_mm;
  for (int round = 0; round < kMostRounds; ++round) {
    const Vec3<double> motors_mm = descent(z_mm);
    if (!motors_mm.allFinite()) return std::nullopt;
    const auto pose = DeltaPoseOf(build, motors_mm);
    if (!pose) return std::nullopt;
    const Vec3<double> tip_mm =
        pose->nozzle_mm + delta_chain::Rotated(pose->cayley, tip.AtTrigger_mm());
    const double above_mm = tip_mm[2] - bed.Height_mm(tip_mm[0], tip_mm[1]);
    if (std::abs(above_mm) < kThere_mm) return z_mm;
    z_mm -= above_mm;
  }
  return std::nullopt;
}

std::optional<Vec3<double>> DeltaTouchMotors(const DeltaBuild<double>& build,
                                             const DeltaBed<double>& bed,
                                             const DeltaModel<double>& settings,
                                             double x_mm,
                                             double y_mm,
                                             const DeltaTip& tip) {
  const auto descent = [&](double z_mm) {
    return DeltaMotors_mm<double>(settings, {x_mm, y_mm, z_mm});
  };
  const auto z_mm =
      DeltaTouchHeight_mm(build, bed, descent, bed.Height_mm(x_mm, y_mm), tip);
  return z_mm ? std::optional(descent(*z_mm)) : std::nullopt;
}

DeltaAccuracy DeltaAccuracyOf(const DeltaBuild<double>& build,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm) {
  return DeltaAccuracyOf(build, bed, settings, radius_mm, DeltaMesh{});
}

DeltaAccuracy DeltaAccuracyOf(const DeltaBuild<double>& build,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm,
                              const DeltaMesh& mesh) {
  const auto nozzle_of =
      [&](const Vec3<double>& motors_mm) -> std::optional<Vec3<double>> {
    const auto pose = DeltaPoseOf(build, motors_mm);
    if (!pose) return std::nullopt;
    return pose->nozzle_mm;
  };
  return DeltaAccuracyOf(nozzle_of, bed, settings, radius_mm, mesh);
}

DeltaAccuracy DeltaAccuracyOf(const NozzleOfMotors& nozzle_of,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm,
                              const DeltaMesh& mesh) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3<double>> commanded = OnDisc(radius_mm);
  std::vector<Vec3<double>> moved;
  DeltaAccuracy accuracy;
  double sum = 0, square = 0;
  const auto num = static_cast<double>(commanded.size());
  for (const Vec3<double>& at : commanded) {
    const Vec3<double> lifted = at + mesh.Lift_mm(at[0], at[1]) * Unit(Axis::kZ);
    const auto nozzle_mm = nozzle_of(DeltaMotors_mm(settings, lifted));
    if (!nozzle_mm) return {kNaN, kNaN, kNaN, kNaN, kNaN};
    moved.push_back(*nozzle_mm);
    const double above_mm =
        moved.back()[2] - bed.Height_mm(moved.back()[0], moved.back()[1]);
    accuracy.z_most_mm = std::max(accuracy.z_most_mm, std::abs(above_mm));
    sum += above_mm / num;
    square += above_mm * above_mm / num;
  }
  accuracy.z_rms_mm = std::sqrt(square);
  accuracy.z_flat_rms_mm = std::sqrt(std::max(0.0, square - sum * sum));
  AddPlane(commanded, moved, &accuracy);
  return accuracy;
}

double DeltaHeightChange_mm(const DeltaBuild<double>& build,
                            const DeltaModel<double>& from,
                            const DeltaModel<double>& to,
                            double radius_mm) {
  const std::vector<Vec3<double>> commanded = OnDisc(radius_mm);
  double square = 0;
  for (const Vec3<double>& at : commanded) {
    const auto before = DeltaPoseOf(build, DeltaMotors_mm(from, at));
    const auto after = DeltaPoseOf(build, DeltaMotors_mm(to, at));
    if (!before || !after) return std::numeric_limits<double>::quiet_NaN();
    square += std::pow(after->nozzle_mm[2] - before->nozzle_mm[2], 2);
  }
  return std::sqrt(square / static_cast<double>(commanded.size()));
}

}  // namespace caltwin
