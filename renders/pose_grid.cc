#include "renders/pose_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <nlohmann/json.hpp>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;
using Poses = std::vector<BodyPose>;
using Counts = std::array<std::size_t, 3>;

constexpr std::size_t kMostNodes = 17;  // 2, 3, 5, 9, 17.
constexpr double kArm_mm = 200;
constexpr std::size_t kNumLengths = 3;  // Of a pose's numbers; the others turn it.

std::optional<Poses> Moved(const Still& still,
                           const std::vector<int>& bodies,
                           const Vec3<double>& tip_mm) {
  if (!still.move_to(tip_mm)) return std::nullopt;
  return PosesOf(*still.data, bodies);
}

std::vector<double> Nodes_mm(const std::array<double, 2>& travel_mm,
                             std::size_t count) {
  std::vector<double> nodes_mm;
  for (std::size_t i = 0; i < count; ++i) {
    nodes_mm.push_back(
        std::lerp(travel_mm[0],
                  travel_mm[1],
                  static_cast<double>(i) / static_cast<double>(count - 1)));
  }
  return nodes_mm;
}

using Nodes = std::array<std::vector<double>, 3>;

/// Every place of a grid of nodes, z fastest.
std::vector<Vec3<double>> PlacesOf(const Nodes& nodes_mm) {
  std::vector<Vec3<double>> places_mm;
  for (const double x_mm : nodes_mm[0]) {
    for (const double y_mm : nodes_mm[1]) {
      for (const double z_mm : nodes_mm[2]) places_mm.emplace_back(x_mm, y_mm, z_mm);
    }
  }
  return places_mm;
}

PoseGrid Sampled(const Still& still, const Counts& counts) {
  PoseGrid grid{.bodies = MovingBodies(*still.model)};
  for (std::size_t axis = 0; axis < counts.size(); ++axis) {
    grid.nodes_mm[axis] = Nodes_mm(still.travel_mm[axis], counts[axis]);
  }
  for (const Vec3<double>& at_mm : PlacesOf(grid.nodes_mm)) {
    grid.poses.push_back(Moved(still, grid.bodies, at_mm));
  }
  return grid;
}

/// How far the grid is off half-way between its nodes along an axis; infinite where it
/// does not know what the machine reaches.
double GapAlong_mm(const Still& still, const PoseGrid& grid, std::size_t axis) {
  Nodes middles_mm = grid.nodes_mm;
  std::vector<double>& along_mm = middles_mm[axis];
  for (std::size_t i = 0; i + 1 < along_mm.size(); ++i) {
    along_mm[i] = std::midpoint(along_mm[i], along_mm[i + 1]);
  }
  along_mm.pop_back();
  double gap_mm = 0;
  for (const Vec3<double>& at_mm : PlacesOf(middles_mm)) {
    const auto there = Moved(still, grid.bodies, at_mm);
    if (!there) continue;
    const auto held = PosesAt(grid, at_mm);
    if (!held) return std::numeric_limits<double>::infinity();
    gap_mm = std::max(gap_mm, Apart_mm(*there, *held));
  }
  return gap_mm;
}

/// The node below a place, and how far towards the next it is.
std::pair<std::size_t, double> CellOf(const std::vector<double>& nodes_mm,
                                      double at_mm) {
  const auto last = static_cast<std::ptrdiff_t>(nodes_mm.size()) - 2;
  const auto above = std::ranges::upper_bound(nodes_mm, at_mm) - nodes_mm.begin();
  const auto low =
      static_cast<std::size_t>(std::clamp(above - 1, std::ptrdiff_t{0}, last));
  return {low, (at_mm - nodes_mm[low]) / (nodes_mm[low + 1] - nodes_mm[low])};
}

/// Whether a quaternion means the same turn as the other with its sign changed.
bool IsOpposed(const BodyPose& one, const BodyPose& other) {
  double product = 0;
  for (std::size_t i = kNumLengths; i < one.size(); ++i) product += one[i] * other[i];
  return product < 0;
}

/// Adds a share of each pose to the sum, turned in the sense of those of `like`.
void AddShare(const Poses& poses, const Poses& like, double share, Poses* sum) {
  for (std::size_t body = 0; body < poses.size(); ++body) {
    const BodyPose& pose = poses[body];
    const double turned = IsOpposed(pose, like[body]) ? -share : share;
    for (std::size_t i = 0; i < pose.size(); ++i) {
      (*sum)[body][i] += (i < kNumLengths ? share : turned) * pose[i];
    }
  }
}

void Normalise(Poses* poses) {
  for (BodyPose& pose : *poses) {
    const double length =
        std::hypot(std::hypot(pose[3], pose[4]), std::hypot(pose[5], pose[6]));
    for (std::size_t i = kNumLengths; i < pose.size(); ++i) pose[i] /= length;
  }
}

double Rounded(double value, double parts) {
  return std::round(value * parts) / parts;
}

}  // namespace

double Apart_mm(const Poses& some, const Poses& others) {
  double apart_mm = 0;
  for (std::size_t body = 0; body < some.size(); ++body) {
    const BodyPose& one = some[body];
    const BodyPose& other = others[body];
    const double sign = IsOpposed(one, other) ? -1 : 1;
    double length = 0, turn = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      const bool is_length = i < kNumLengths;
      const double gap = one[i] - (is_length ? 1 : sign) * other[i];
      (is_length ? length : turn) += gap * gap;
    }
    // Half the angle is what a quaternion holds.
    apart_mm = std::max(apart_mm, std::sqrt(length) + 2 * kArm_mm * std::sqrt(turn));
  }
  return apart_mm;
}

PoseGrid GridOfPoses(const Still& still, double tolerance_mm) {
  Counts counts = {2, 2, 2};
  for (;;) {
    PoseGrid grid = Sampled(still, counts);
    bool is_fine = true;
    for (std::size_t axis = 0; axis < counts.size(); ++axis) {
      if (counts[axis] == kMostNodes) continue;
      if (GapAlong_mm(still, grid, axis) <= tolerance_mm) continue;
      counts[axis] = 2 * counts[axis] - 1;
      is_fine = false;
    }
    if (is_fine) return grid;
  }
}

std::optional<Poses> PosesAt(const PoseGrid& grid, const Vec3<double>& tip_mm) {
  const auto [x, share_x] = CellOf(grid.nodes_mm[0], tip_mm.x());
  const auto [y, share_y] = CellOf(grid.nodes_mm[1], tip_mm.y());
  const auto [z, share_z] = CellOf(grid.nodes_mm[2], tip_mm.z());
  Poses sum(grid.bodies.size());
  const Poses* like = nullptr;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t right = corner & 1, back = corner >> 1 & 1, up = corner >> 2;
    const double share = (right != 0 ? share_x : 1 - share_x) *
                         (back != 0 ? share_y : 1 - share_y) *
                         (up != 0 ? share_z : 1 - share_z);
    if (share == 0) continue;
    const auto& node = grid.poses[grid.IndexOf(x + right, y + back, z + up)];
    if (!node) return std::nullopt;
    if (like == nullptr) like = &*node;
    AddShare(*node, *like, share, &sum);
  }
  Normalise(&sum);
  return sum;
}

Json ToJson(const PoseGrid& grid) {
  constexpr double kPerMm = 1e3, kPerTurn = 1e5;
  Json poses = Json::array();
  for (const auto& node : grid.poses) {
    if (!node) {
      poses.push_back(nullptr);
      continue;
    }
    Json bodies = Json::array();
    for (const BodyPose& pose : *node) {
      Json numbers = Json::array();
      for (std::size_t i = 0; i < pose.size(); ++i) {
        numbers.push_back(Rounded(pose[i], i < kNumLengths ? kPerMm : kPerTurn));
      }
      bodies.push_back(std::move(numbers));
    }
    poses.push_back(std::move(bodies));
  }
  return {{"nodes_mm", grid.nodes_mm},
          {"bodies", grid.bodies},
          {"poses", std::move(poses)}};
}

}  // namespace caltwin
