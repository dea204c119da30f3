#include "tests/blind/delta/parts.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace blind {
namespace {

constexpr ByTower kAngle_deg = {210, 330, 90};

double AngleOf(int tower) {
  return kAngle_deg[static_cast<std::size_t>(tower)] * std::numbers::pi / 180;
}

// Carriage height above the nozzle's when the nozzle hangs in the middle.
double Reach_mm(const DeltaPaper& paper) {
  return std::sqrt(paper.arm_mm * paper.arm_mm - paper.radius_mm * paper.radius_mm);
}

struct Rod {
  Vec top = Vec::Zero();     ///< On the carriage, machine frame.
  Vec bottom = Vec::Zero();  ///< On the effector, from the nozzle.
  double length_mm = 0;
};

std::array<Rod, 6> RodsOf(const DeltaPaper& paper,
                          const DeltaMade& made,
                          const Vec& travel_mm) {
  std::array<Rod, 6> rods;
  for (int tower = 0; tower < 3; ++tower) {
    const auto i = static_cast<std::size_t>(tower);
    const double angle = AngleOf(tower) + made.angle[i];
    const Vec out(std::cos(angle), std::sin(angle), 0);
    const Vec round(-std::sin(angle), std::cos(angle), 0);
    // A tower that stands round leaves the effector as it is drawn.
    const Vec drawn_out(std::cos(AngleOf(tower)), std::sin(AngleOf(tower)), 0);
    const Vec drawn_round(-std::sin(AngleOf(tower)), std::cos(AngleOf(tower)), 0);
    const double height_mm = paper.endstop_mm + made.endstop_mm[i] + Reach_mm(paper) +
                             paper.joint_height_mm -
                             (1 + made.belt[i]) * travel_mm[tower];
    // A bow: nought at the bed and at the endstop, all of it between.
    const double top_mm = paper.endstop_mm + Reach_mm(paper);
    const double along = height_mm / top_mm;
    const double bow_mm = 4 * made.bow_mm[i] * along * (1 - along);
    const Vec carriage =
        out * (paper.radius_mm + made.radius_mm[i] + paper.effector_radius_mm +
               height_mm * made.lean_out[i] + bow_mm) +
        round * height_mm * made.lean_round[i] + Vec(0, 0, height_mm);
    const Vec across(
        -std::sin(angle + made.twist[i]), std::cos(angle + made.twist[i]), 0);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t k = 2 * i + side;
      const double half_mm = (side == 0 ? -0.5 : 0.5) * paper.rod_spacing_mm;
      rods[k] = {carriage + across * half_mm,
                 drawn_out * paper.effector_radius_mm + drawn_round * half_mm +
                     Vec(0, 0, paper.joint_height_mm),
                 paper.arm_mm + made.arm_mm + made.rod_mm[k]};
    }
  }
  return rods;
}

}  // namespace

Vec TravelFor(const DeltaPaper& paper, const Vec& nozzle_mm) {
  Vec travel_mm;
  for (int tower = 0; tower < 3; ++tower) {
    const double dx = paper.radius_mm * std::cos(AngleOf(tower)) - nozzle_mm.x();
    const double dy = paper.radius_mm * std::sin(AngleOf(tower)) - nozzle_mm.y();
    const double up_mm = std::sqrt(paper.arm_mm * paper.arm_mm - dx * dx - dy * dy);
    travel_mm[tower] = paper.endstop_mm + Reach_mm(paper) - nozzle_mm.z() - up_mm;
  }
  return travel_mm;
}

std::optional<Vec> NozzleAt(const DeltaPaper& paper,
                            const DeltaMade& made,
                            const Vec& travel_mm) {
  constexpr int kRounds = 40;
  const auto rods = RodsOf(paper, made, travel_mm);
  double mean_mm = 0;
  for (const Rod& rod : rods) mean_mm += rod.top.z() / 6;
  Vec place(0, 0, mean_mm - Reach_mm(paper) - paper.joint_height_mm);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> slope;
    Eigen::Matrix<double, 6, 1> wrong;
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Rod& rod = rods[static_cast<std::size_t>(k)];
      const Vec arm = turn * rod.bottom;
      const Vec along = place + arm - rod.top;
      wrong[k] = along.norm() - rod.length_mm;
      slope.row(k).head<3>() = along.normalized();
      slope.row(k).tail<3>() = arm.cross(along.normalized());
    }
    const Eigen::Matrix<double, 6, 1> step = slope.partialPivLu().solve(wrong);
    if (!step.allFinite()) return std::nullopt;
    place -= step.head<3>();
    const double by = step.tail<3>().norm();
    if (by > 0) turn = Eigen::AngleAxisd(-by, step.tail<3>() / by) * turn;
    if (step.head<3>().norm() < 1e-10) return place;
  }
  return std::nullopt;
}

}  // namespace blind
