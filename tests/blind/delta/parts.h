#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace blind {

using Vec = Eigen::Vector3d;
using ByTower = std::array<double, 3>;

/// What is drawn of a delta and what its firmware believes: three rods, towers a b c at
/// 210, 330 and 90 deg counter-clockwise from +x.
struct DeltaPaper {
  double radius_mm = 130, arm_mm = 250, endstop_mm = 300;
  double rod_spacing_mm = 45, effector_radius_mm = 35, joint_height_mm = 20;
  double bed_radius_mm = 100;  ///< That is touched.
  double pulley_mm = 40;
};

/// Carriage travel (down) for a nozzle pose, by the paper.
Vec TravelFor(const DeltaPaper& paper, const Vec& nozzle_mm);

/// How a delta is made, against its paper. Angles counter-clockwise from above [rad];
/// lean as slopes, outward and counter-clockwise; belts as moved / commanded - 1.
struct DeltaMade {
  ByTower endstop_mm{}, radius_mm{}, angle{}, lean_out{}, lean_round{}, twist{}, belt{};
  double arm_mm = 0;
  std::array<double, 6> rod_mm{};
  /// Outside every catalogue: a tower that is bowed outward by so much in its middle,
  /// and a carriage whose rods give by so much, sideways either way.
  ByTower bow_mm{};
  ByTower slack_mm{};
};

/// Where the nozzle is: six rods of fixed length between carriages and a rigid
/// effector, solved for its place and its turn. Empty where they do not reach.
std::optional<Vec> NozzleAt(const DeltaPaper& paper,
                            const DeltaMade& made,
                            const Vec& travel_mm);

}  // namespace blind
