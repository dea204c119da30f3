#pragma once

#include <array>
#include <vector>

#include <mujoco/mujoco.h>
#include <nlohmann/json_fwd.hpp>

#include "renders/kinds/still.h"

namespace caltwin {

/// What a machine looks like, for somebody else's renderer: its name, whether its tip
/// `moves` and where, `bodies` by name, `geoms` on them (pose in the body's frame),
/// `rods` between two of them, `meshes`, and `poses` of the bodies as they stand.
/// Lengths in mm; a pose is x, y, z and a quaternion w, x, y, z.
nlohmann::ordered_json SceneJson(const Still& still);

/// Where a body stands: x, y, z [mm] and a quaternion w, x, y, z.
using BodyPose = std::array<double, 7>;

/// The poses of those bodies.
std::vector<BodyPose> PosesOf(const mjData& data, const std::vector<int>& bodies);
/// The same with six decimals.
nlohmann::ordered_json PosesJson(const mjData& data, const std::vector<int>& bodies);

/// The bodies that hang on a joint.
std::vector<int> MovingBodies(const mjModel& model);

}  // namespace caltwin
