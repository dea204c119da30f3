#pragma once

// The templates of delta.h.

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace delta_chain {

/// The number without its derivatives.
template <typename T>
double Plain(const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    return value;
  } else {
    return value.a;
  }
}

template <typename T, std::size_t n>
std::array<double, n> Plain(const std::array<T, n>& values) {
  std::array<double, n> plain{};
  for (std::size_t i = 0; i < n; ++i) plain[i] = Plain(values[i]);
  return plain;
}

template <typename T>
DeltaModel<double> Plain(const DeltaModel<T>& model) {
  return {Plain(model.endstop_mm),
          Plain(model.radius_mm),
          Plain(model.angle_rad),
          Plain(model.arm_mm)};
}

template <typename T>
DeltaBuild<double> Plain(const DeltaBuild<T>& build) {
  return {.model = Plain(build.model),
          .rod_error_mm = Plain(build.rod_error_mm),
          .lean_radial_rad = Plain(build.lean_radial_rad),
          .lean_tangential_rad = Plain(build.lean_tangential_rad),
          .twist_rad = Plain(build.twist_rad),
          .belt_scale = Plain(build.belt_scale),
          .tool_tilt_x_rad = Plain(build.tool_tilt_x_rad),
          .tool_tilt_y_rad = Plain(build.tool_tilt_y_rad),
          .rod_spacing_mm = build.rod_spacing_mm,
          .effector_radius_mm = build.effector_radius_mm,
          .joint_height_mm = build.joint_height_mm};
}

template <typename T>
Vec3<T> Radial(const T& angle_rad) {
  using std::cos;
  using std::sin;
  return {cos(angle_rad), sin(angle_rad), T(0)};
}

template <typename T>
Vec3<T> Tangential(const T& angle_rad) {
  using std::cos;
  using std::sin;
  return {-sin(angle_rad), cos(angle_rad), T(0)};
}

/// R v, R = I + 2 / (1 + g.g) ([g]x + [g]x [g]x).
template <typename T>
Vec3<T> Rotated(const Vec3<T>& cayley, const Vec3<T>& v) {
  const Vec3<T> once = cayley.cross(v);
  const Vec3<T> twice = cayley.cross(once);
  return v + (once + twice) * (T(2) / (T(1) + cayley.dot(cayley)));
}

/// The upper ends of the six rods, at these motor travels.
template <typename T>
std::array<Vec3<T>, 6> UpperJoints_mm(const DeltaBuild<T>& build,
                                      const Vec3<T>& motors_mm) {
  using std::sqrt;
  std::array<Vec3<T>, 6> joints;
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const DeltaModel<T>& model = build.model;
    const T arm = model.arm_mm[at], radius = model.radius_mm[at];
    const T height = model.endstop_mm[at] + sqrt(arm * arm - radius * radius) +
                     T(build.joint_height_mm) -
                     motors_mm[i] * (T(1) + build.belt_scale[at]);
    const Vec3<T> out = Radial(model.angle_rad[at]);
    const Vec3<T> along = Tangential(model.angle_rad[at]);
    const Vec3<T> foot = out * (radius + T(build.effector_radius_mm));
    Vec3<T> up =
        out * build.lean_radial_rad[at] + along * build.lean_tangential_rad[at];
    up[2] = T(1);
    up /= sqrt(up.dot(up));
    const Vec3<T> centre = foot + up * height;
    const Vec3<T> half = Tangential(model.angle_rad[at] + build.twist_rad[at]) *
                         T(build.rod_spacing_mm / 2);
    joints[2 * at] = centre - half;
    joints[2 * at + 1] = centre + half;
  }
  return joints;
}

/// The tool's tip against the middle of the effector's joints: a tilted tool's stands
/// off the effector's axis.
template <typename T>
Vec3<T> ToolTip_mm(const DeltaBuild<T>& build) {
  return Rotated<T>({build.tool_tilt_x_rad / T(2), build.tool_tilt_y_rad / T(2), T(0)},
                    {T(0), T(0), T(-build.joint_height_mm)});
}

/// The lower ends of the rods in the effector's frame, the tip at its origin.
template <typename T>
std::array<Vec3<T>, 6> LowerJoints_mm(const DeltaBuild<T>& build) {
  const Vec3<T> tip = ToolTip_mm(build);
  std::array<Vec3<T>, 6> joints;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const Vec3<T> centre =
        Radial(build.model.angle_rad[i]) * T(build.effector_radius_mm) - tip;
    const Vec3<T> half =
        Tangential(build.model.angle_rad[i]) * T(build.rod_spacing_mm / 2);
    joints[2 * i] = centre - half;
    joints[2 * i + 1] = centre + half;
  }
  return joints;
}

/// |nozzle + R e_k - c_k|^2 - L_k^2 of the six rods [mm^2].
template <typename T>
Eigen::Matrix<T, 6, 1> Open_mm2(const DeltaBuild<T>& build,
                                const std::array<Vec3<T>, 6>& upper,
                                const std::array<Vec3<T>, 6>& lower,
                                const DeltaPose<T>& pose) {
  Eigen::Matrix<T, 6, 1> open;
  for (std::size_t k = 0; k < kNumRods; ++k) {
    const Vec3<T> rod = pose.nozzle_mm + Rotated(pose.cayley, lower[k]) - upper[k];
    const T length = build.model.arm_mm[k / 2] + build.rod_error_mm[k];
    open[static_cast<Eigen::Index>(k)] = rod.dot(rod) - length * length;
  }
  return open;
}

/// Its derivative by nozzle and Cayley parameters, those taken as small: the tilt of an
/// effector is milliradians, and Newton's method corrects the rest.
Eigen::Matrix<double, 6, 6> Slope(const std::array<Vec3<double>, 6>& upper,
                                  const std::array<Vec3<double>, 6>& lower,
                                  const DeltaPose<double>& pose);

/// The chain closed in plain numbers; nullopt where it does not.
struct Closed {
  DeltaPose<double> pose{};
  Eigen::Matrix<double, 6, 6> slope{};
};
/// `start`: a pose near by; without it the three-rod formulas'.
std::optional<Closed> Close(const DeltaBuild<double>& build,
                            const Vec3<double>& motors_mm,
                            const DeltaPose<double>* start = nullptr);

}  // namespace delta_chain

template <typename T>
Vec3<T> DeltaMotors_mm(const DeltaModel<T>& model, const Vec3<T>& nozzle_mm) {
  using std::sqrt;
  Vec3<T> motors_mm;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const T arm2 = model.arm_mm[i] * model.arm_mm[i];
    const Vec3<T> tower = delta_chain::Radial(model.angle_rad[i]) * model.radius_mm[i];
    const T dx = tower[0] - nozzle_mm[0], dy = tower[1] - nozzle_mm[1];
    const T carriage = nozzle_mm[2] + sqrt(arm2 - dx * dx - dy * dy);
    motors_mm[static_cast<Eigen::Index>(i)] =
        model.endstop_mm[i] + sqrt(arm2 - model.radius_mm[i] * model.radius_mm[i]) -
        carriage;
  }
  return motors_mm;
}

template <typename T>
Vec3<T> DeltaNozzle_mm(const DeltaModel<T>& model, const Vec3<T>& motors_mm) {
  using std::sqrt;
  std::array<Vec3<T>, 3> centre;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const T arm = model.arm_mm[i], radius = model.radius_mm[i];
    centre[i] = delta_chain::Radial(model.angle_rad[i]) * radius;
    centre[i][2] = model.endstop_mm[i] + sqrt(arm * arm - radius * radius) -
                   motors_mm[static_cast<Eigen::Index>(i)];
  }
  // Spheres less the first: two planes, whose line meets the first sphere twice.
  const Vec3<T> u = centre[1] - centre[0], v = centre[2] - centre[0];
  const auto power = [&](std::size_t i) {
    return centre[i].dot(centre[i]) - model.arm_mm[i] * model.arm_mm[i];
  };
  const T du = (power(1) - power(0)) / T(2), dv = (power(2) - power(0)) / T(2);
  Vec3<T> along = u.cross(v);
  const T area2 = along.dot(along);
  // The point of the line nearest to the origin: u.p = du, v.p = dv, along.p = 0.
  const Vec3<T> nearest = (v.cross(along) * du + along.cross(u) * dv) / area2;
  along /= sqrt(area2);
  const Vec3<T> from = nearest - centre[0];
  const T b = along.dot(from);
  const T c = from.dot(from) - model.arm_mm[0] * model.arm_mm[0];
  const T root = sqrt(b * b - c);
  const Vec3<T> one = nearest + along * (root - b);
  const Vec3<T> other = nearest - along * (root + b);
  return delta_chain::Plain(one[2]) < delta_chain::Plain(other[2]) ? one : other;
}

template <typename T>
std::optional<DeltaPose<T>> DeltaPoseOf(const DeltaBuild<T>& build,
                                        const Vec3<T>& motors_mm) {
  using delta_chain::Plain;
  const Vec3<double> motors(
      Plain(motors_mm[0]), Plain(motors_mm[1]), Plain(motors_mm[2]));
  if constexpr (std::is_arithmetic_v<T>) {
    const auto closed = delta_chain::Close(build, motors);
    if (!closed) return std::nullopt;
    return closed->pose;
  } else {
    const auto closed = delta_chain::Close(Plain(build), motors);
    if (!closed) return std::nullopt;
    // One more Newton step in T: the implicit function's derivatives.
    DeltaPose<T> pose;
    pose.nozzle_mm = closed->pose.nozzle_mm.template cast<T>();
    pose.cayley = closed->pose.cayley.template cast<T>();
    const auto open =
        delta_chain::Open_mm2(build,
                              delta_chain::UpperJoints_mm(build, motors_mm),
                              delta_chain::LowerJoints_mm(build),
                              pose);
    const Eigen::Matrix<double, 6, 6> inverse = closed->slope.inverse();
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < kNumRods; ++k) {
        pose.nozzle_mm[i] -= open[k] * inverse(i, k);
        pose.cayley[i] -= open[k] * inverse(i + 3, k);
      }
    }
    return pose;
  }
}

}  // namespace caltwin
