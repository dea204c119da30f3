#include "sim/mjcf/spec.h"

#include <array>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"

namespace caltwin {

SpecPtr ReadSpec(const std::filesystem::path& file) {
  std::array<char, 1000> error{};
  SpecPtr spec(mj_parseXML(file.c_str(), nullptr, error.data(), error.size()));
  if (!spec) {
    throw InputError({.file = file.string()},
                     fmt::format("MuJoCo cannot read this model: {}", error.data()));
  }
  return spec;
}

mjsElement* FindElement(const mjSpec* spec, mjtObj type, const std::string& name) {
  mjsElement* element = mjs_findElement(spec, type, name.c_str());
  Require(element != nullptr, fmt::format("the model has no '{}'", name));
  return element;
}

void MakeHard(double timestep_s, double damping_ratio, mjtNum* solref, mjtNum* solimp) {
  solref[0] = 2 * timestep_s;
  solref[1] = damping_ratio;
  solimp[0] = solimp[1] = 0.9999;
  solimp[2] = 0.001;
}

void SetQuat(const Eigen::Quaterniond& q, double quat[4]) {
  quat[0] = q.w();
  quat[1] = q.x();
  quat[2] = q.y();
  quat[3] = q.z();
}

void SetPosition(const Vec3<double>& mm, double pos[3]) {
  for (int i = 0; i < 3; ++i) pos[i] = mm[i] * kMPerMm;
}

}  // namespace caltwin
