#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <Eigen/Geometry>
#include <mujoco/mujoco.h>

#include "sim/machine/axis.h"

namespace caltwin {

inline constexpr double kMPerMm = 1e-3;
inline constexpr int kTouchable = 2;  ///< Contact bit of the tip and all it may touch.

struct DeleteSpec {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using SpecPtr = std::unique_ptr<mjSpec, DeleteSpec>;

/// Reads MJCF; throws InputError with MuJoCo's own words where it cannot.
SpecPtr ReadSpec(const std::filesystem::path& file);

/// The element of that name, which is there.
mjsElement* FindElement(const mjSpec* spec, mjtObj type, const std::string& name);

/// Makes every constraint solver figure of a solref and solimp those of rigid metrology
/// (PHYSICS): a time constant of two steps.
void MakeHard(double timestep_s, double damping_ratio, mjtNum* solref, mjtNum* solimp);

void SetQuat(const Eigen::Quaterniond& q, double quat[4]);
void SetPosition(const Vec3<double>& mm, double pos[3]);

}  // namespace caltwin
