#pragma once

#include <vector>

#include <mujoco/mujoco.h>
#include <nlohmann/json_fwd.hpp>

namespace caltwin {

/// What a model looks like, for somebody else's renderer: `bodies` by name, `geoms` on
/// them (pose in the body's frame), `meshes`, and `poses` of the bodies as they stand
/// in `data`. Lengths in mm; a pose is x, y, z and a quaternion w, x, y, z.
nlohmann::ordered_json SceneJson(const mjModel& model, const mjData& data);

/// The poses of those bodies.
nlohmann::ordered_json PosesJson(const mjData& data, const std::vector<int>& bodies);

/// The bodies that hang on a joint.
std::vector<int> MovingBodies(const mjModel& model);

}  // namespace caltwin
