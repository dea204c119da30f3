#include "sim/machine/kinds/delta/model.h"

#include <cmath>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::string_view kTowers = "abc";
constexpr int kMostRounds = 30;

}  // namespace

namespace delta_chain {

Eigen::Matrix<double, 6, 6> Slope(const std::array<Vec3<double>, 6>& upper,
                                  const std::array<Vec3<double>, 6>& lower,
                                  const DeltaPose<double>& pose) {
  Eigen::Matrix<double, 6, 6> slope;
  const Vec3<double>& g = pose.cayley;
  const double scale = 1 / (1 + g.dot(g));
  for (std::size_t k = 0; k < kNumRods; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Vec3<double> arm = Rotated(g, lower[k]);
    const Vec3<double> rod = pose.nozzle_mm + arm - upper[k];
    slope.row(row).head<3>() = 2 * rod.transpose();
    // d(R e) = omega x R e with omega = 2 (dg + g x dg) / (1 + g.g).
    const Vec3<double> torque = arm.cross(rod);
    slope.row(row).tail<3>() = 4 * scale * (torque + torque.cross(g)).transpose();
  }
  return slope;
}

std::optional<Closed> Close(const DeltaBuild<double>& build,
                            const Vec3<double>& motors_mm,
                            const DeltaPose<double>* start) {
  constexpr double kClosed_mm = 1e-11;
  const auto upper = UpperJoints_mm(build, motors_mm);
  const auto lower = LowerJoints_mm(build);
  Closed closed;
  if (start != nullptr) {
    closed.pose = *start;
  } else {
    closed.pose.nozzle_mm = DeltaNozzle_mm(build.model, motors_mm);
  }
  if (!closed.pose.nozzle_mm.allFinite()) return std::nullopt;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto open = Open_mm2(build, upper, lower, closed.pose);
    closed.slope = Slope(upper, lower, closed.pose);
    const Eigen::Matrix<double, 6, 1> step = closed.slope.partialPivLu().solve(open);
    if (!step.allFinite()) return std::nullopt;
    closed.pose.nozzle_mm -= step.head<3>();
    closed.pose.cayley -= step.tail<3>();
    if (step.head<3>().norm() < kClosed_mm) return closed;
  }
  return std::nullopt;
}

}  // namespace delta_chain

std::string TowerName(int tower) {
  return {kTowers[static_cast<std::size_t>(tower)]};
}

std::optional<int> TowerNamed(std::string_view name) {
  if (name.size() != 1 || kTowers.find(name) == std::string_view::npos) {
    return std::nullopt;
  }
  return static_cast<int>(kTowers.find(name));
}

std::string RodName(int rod) {
  return TowerName(rod / 2) + (rod % 2 == 0 ? "1" : "2");
}

std::optional<int> RodNamed(std::string_view name) {
  for (int rod = 0; rod < kNumRods; ++rod) {
    if (name == RodName(rod)) return rod;
  }
  return std::nullopt;
}

DeltaModel<double> SymmetricDelta(double endstop_mm, double radius_mm, double arm_mm) {
  DeltaModel<double> model;
  model.endstop_mm.fill(endstop_mm);
  model.radius_mm.fill(radius_mm);
  model.arm_mm.fill(arm_mm);
  model.angle_rad = {RadFromDeg(210.0), RadFromDeg(330.0), RadFromDeg(90.0)};
  return model;
}

double TwistPerAngle(const DeltaModel<double>& drawn, double effector_radius_mm) {
  const double radius_mm = MeanOfTowers(drawn.radius_mm);
  return radius_mm / (radius_mm + effector_radius_mm);
}

void StandRound(int tower, double angle_rad, DeltaBuild<double>* build) {
  const auto i = static_cast<std::size_t>(tower);
  if (build->twist_per_angle == 0) {
    build->model.angle_rad[i] += angle_rad;
    return;
  }
  // From the effector's joint, which stays, to the carriage's, which goes round.
  const double carriage_mm = build->model.radius_mm[i] + build->effector_radius_mm;
  const double out_mm = carriage_mm * std::cos(angle_rad) - build->effector_radius_mm;
  const double round_mm = carriage_mm * std::sin(angle_rad);
  build->model.radius_mm[i] = std::hypot(out_mm, round_mm);
  build->model.angle_rad[i] += std::atan2(round_mm, out_mm);
  build->twist_rad[i] += angle_rad;
}

DeltaBuild<double> WithSettings(DeltaBuild<double> drawn,
                                const DeltaModel<double>& settings) {
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    drawn.twist_rad[i] +=
        drawn.twist_per_angle * (settings.angle_rad[i] - drawn.model.angle_rad[i]);
  }
  drawn.model = settings;
  return drawn;
}

double MeanOfTowers(const std::array<double, 3>& values) {
  return (values[0] + values[1] + values[2]) / 3;
}

std::optional<Vec3<double>> DeltaMotorsOf(const DeltaBuild<double>& build,
                                          const Vec3<double>& nozzle_mm) {
  constexpr double kThere_mm = 1e-10;
  Vec3<double> motors_mm = DeltaMotors_mm(build.model, nozzle_mm);
  if (!motors_mm.allFinite()) return std::nullopt;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto closed = delta_chain::Close(build, motors_mm);
    if (!closed) return std::nullopt;
    const Vec3<double> off_mm = nozzle_mm - closed->pose.nozzle_mm;
    if (off_mm.norm() < kThere_mm) return motors_mm;
    // Three-rod slopes are near enough: the errors are small.
    const Vec3<double> to = closed->pose.nozzle_mm + off_mm;
    motors_mm += DeltaMotors_mm(build.model, to) -
                 DeltaMotors_mm(build.model, closed->pose.nozzle_mm);
  }
  return std::nullopt;
}

}  // namespace caltwin
