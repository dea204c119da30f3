#include "sim/machine/kinds/delta/slopes.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

using Joints = std::array<Vec3<double>, 6>;

/// What a tower's carriage is made of, as UpperJoints_mm has it.
struct Carriage {
  Vec3<double> out, along, up;
  double lean_norm = 1;
  double height_mm = 0;
  double drop_mm = 0;  ///< sqrt(arm^2 - radius^2).

  Carriage(const DeltaBuild<double>& build, std::size_t i, double motor_mm)
      : out(delta_chain::Radial(build.model.angle_rad[i])),
        along(delta_chain::Tangential(build.model.angle_rad[i])) {
    const double arm = build.model.arm_mm[i], radius = build.model.radius_mm[i];
    drop_mm = std::sqrt(arm * arm - radius * radius);
    height_mm = build.model.endstop_mm[i] + drop_mm + build.joint_height_mm -
                motor_mm * (1 + build.belt_scale[i]);
    up = out * build.lean_radial_rad[i] + along * build.lean_tangential_rad[i];
    up[2] = 1;
    lean_norm = up.norm();
    up /= lean_norm;
  }

  /// d(centre) / d(lean towards `side`).
  Vec3<double> ByLean(const Vec3<double>& side) const {
    return (side - up * up.dot(side)) * (height_mm / lean_norm);
  }
};

}  // namespace

std::optional<ClosedDelta> ClosedDelta::At(const DeltaBuild<double>& build,
                                           const Vec3<double>& motors_mm,
                                           const DeltaPose<double>* start) {
  const auto closed = delta_chain::Close(build, motors_mm, start);
  if (!closed) return std::nullopt;
  return ClosedDelta(build, motors_mm, *closed);
}

std::array<double, kNumDeltaKnobs> ClosedDelta::Slopes(
    const Vec3<double>& along) const {
  const DeltaBuild<double>& build = *build_;
  const Joints upper = delta_chain::UpperJoints_mm(build, motors_mm_);
  const Joints lower = delta_chain::LowerJoints_mm(build);
  const Vec3<double> tip = delta_chain::ToolTip_mm(build);
  Eigen::Matrix<double, 6, 1> wanted = Eigen::Matrix<double, 6, 1>::Zero();
  wanted.head<3>() = along;
  const Eigen::Matrix<double, 6, 1> lambda =
      closed_.slope.transpose().partialPivLu().solve(wanted);
  const Vec3<double> vertical = Unit(Axis::kZ);
  std::array<double, kNumDeltaKnobs> slopes{};
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const Carriage carriage(build, i, motors_mm_[static_cast<Eigen::Index>(i)]);
    const DeltaModel<double>& model = build.model;
    const Vec3<double> half =
        delta_chain::Tangential(model.angle_rad[i] + build.twist_rad[i]) *
        (build.rod_spacing_mm / 2);
    Vec3<double> pull = Vec3<double>::Zero();  // d / d(the carriage's centre).
    double by_angle = 0, by_twist = 0, by_length = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t k = 2 * i + side;
      const Vec3<double> hung = delta_chain::Rotated(closed_.pose.cayley, lower[k]);
      const Vec3<double> rod = closed_.pose.nozzle_mm + hung - upper[k];
      const Vec3<double> p = 2 * lambda[static_cast<Eigen::Index>(k)] * rod;
      const Vec3<double> turned = delta_chain::Rotated<double>(
          closed_.pose.cayley, vertical.cross(lower[k] + tip));
      pull += p;
      by_angle += p.dot(vertical.cross(upper[k]) - turned);
      by_twist += (side == 0 ? -1 : 1) * p.dot(vertical.cross(half));
      const double length = model.arm_mm[i] + build.rod_error_mm[k];
      slopes[kRodKnob + k] = 2 * lambda[static_cast<Eigen::Index>(k)] * length;
      by_length += slopes[kRodKnob + k];
    }
    const double by_height = pull.dot(carriage.up);
    const double by_radius =
        pull.dot(carriage.out) - by_height * model.radius_mm[i] / carriage.drop_mm;
    slopes[kEndstopKnob + i] = by_height;
    slopes[kRadiusKnob] += by_radius;
    if (i < 2) slopes[kAngleKnob + i] = by_angle + build.twist_per_angle * by_twist;
    slopes[kArmKnob] += by_height * model.arm_mm[i] / carriage.drop_mm + by_length;
    if (i < 2) slopes[kTowerRadiusKnob + i] = by_radius;
    slopes[kLeanRadialKnob + i] = pull.dot(carriage.ByLean(carriage.out));
    slopes[kLeanTangentialKnob + i] = pull.dot(carriage.ByLean(carriage.along));
    slopes[kTwistKnob + i] = by_twist;
    slopes[kBeltKnob + i] = -by_height * motors_mm_[static_cast<Eigen::Index>(i)];
  }
  return slopes;
}

double ClosedDelta::HeightOver(const DeltaBed<double>& bed,
                               std::array<double, kNumDeltaKnobs>* slopes) const {
  const double x = closed_.pose.nozzle_mm[0], y = closed_.pose.nozzle_mm[1];
  const double u = x / bed.radius_mm, v = y / bed.radius_mm;
  const double by_x =
      bed.slope_x +
      2 / bed.radius_mm * ((bed.bowl_mm + bed.cylinder_x_mm) * u + bed.twist_mm * v);
  const double by_y =
      bed.slope_y +
      2 / bed.radius_mm * ((bed.bowl_mm + bed.cylinder_y_mm) * v + bed.twist_mm * u);
  *slopes = Slopes({-by_x, -by_y, 1});
  (*slopes)[kBedKnob] = -x;
  (*slopes)[kBedKnob + 1] = -y;
  (*slopes)[kBedKnob + 2] = -(u * u + v * v);
  (*slopes)[kBedKnob + 3] = -u * u;
  (*slopes)[kBedKnob + 4] = -2 * u * v;
  return closed_.pose.nozzle_mm[2] - bed.Height_mm(x, y);
}

}  // namespace caltwin
