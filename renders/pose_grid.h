#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "renders/kinds/still.h"
#include "renders/scene_json.h"

namespace caltwin {

/// Where the moving bodies of a machine stand with its tip at the nodes of a grid over
/// its travel: what a picture of it needs that moves without the program.
struct PoseGrid {
  std::array<std::vector<double>, 3> nodes_mm{};  ///< Along x, y and z, ascending.
  std::vector<int> bodies{};
  /// By node, z fastest, then y; none: the machine does not reach there.
  std::vector<std::optional<std::vector<BodyPose>>> poses{};

  std::size_t IndexOf(std::size_t x, std::size_t y, std::size_t z) const {
    return (x * nodes_mm[1].size() + y) * nodes_mm[2].size() + z;
  }
  /// Whether two nodes along each axis are enough, as on a machine whose carriages go
  /// straight where its tip does.
  bool IsStraight() const { return poses.size() == 8; }
};

/// The grid of a machine with a tip. Along an axis along which poses are affine it has
/// two nodes, else so many that half-way between two of them no body is off by more
/// than `tolerance_mm`, or 17. A body that is turned wrongly is off by how far that
/// takes what is 200 mm away.
PoseGrid GridOfPoses(const Still& still, double tolerance_mm);

/// Poses between the nodes: trilinear, quaternions normalised; beyond the last nodes
/// they go on straight. nullopt: a node that they are made of is out of reach.
std::optional<std::vector<BodyPose>> PosesAt(const PoseGrid& grid,
                                             const Vec3<double>& tip_mm);

/// How far two sets of poses of the same bodies are apart, as GridOfPoses says it.
double Apart_mm(const std::vector<BodyPose>& some, const std::vector<BodyPose>& others);

/// `nodes_mm`, `bodies` and `poses`, to the micrometre.
nlohmann::ordered_json ToJson(const PoseGrid& grid);

}  // namespace caltwin
