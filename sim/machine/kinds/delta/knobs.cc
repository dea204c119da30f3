#include "sim/machine/kinds/delta/knobs.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

std::optional<int> DeltaKnobNamed(std::string_view name) {
  const auto found = std::ranges::find(kDeltaKnobs, name, &DeltaKnob::name);
  if (found == kDeltaKnobs.end()) return std::nullopt;
  return static_cast<int>(found - kDeltaKnobs.begin());
}

std::vector<int> DeltaKnobsNamed(std::span<const std::string> names) {
  std::vector<int> knobs;
  for (const std::string& name : names) {
    const auto knob = DeltaKnobNamed(name);
    if (!knob) {
      std::string all;
      for (const DeltaKnob& one : kDeltaKnobs) all += fmt::format(" {}", one.name);
      throw InputError(
          {}, fmt::format("'{}' is no unknown of a delta", name), "one of" + all);
    }
    if (std::ranges::find(knobs, *knob) == knobs.end()) knobs.push_back(*knob);
  }
  return knobs;
}

double PriorSdOf(int knob, const DeltaBuild<double>& drawn) {
  const DeltaKnob& is = kDeltaKnobs[static_cast<std::size_t>(knob)];
  const double sd = is.prior_sd * is.per_unit;
  const bool is_larger = IsAngleKnob(knob) && drawn.twist_per_angle > 0;
  return is_larger ? sd / drawn.twist_per_angle : sd;
}

double KnobValue(int knob,
                 const DeltaBuild<double>& build,
                 const DeltaBed<double>& bed,
                 const DeltaBuild<double>& drawn) {
  const DeltaBed<double> flat;
  double is = 0, was = 0;
  AtKnob(knob, build, bed, [&is](const double& value) { is = value; });
  AtKnob(knob, drawn, flat, [&was](const double& value) { was = value; });
  double turned = is - was;
  const std::string_view name = kDeltaKnobs[static_cast<std::size_t>(knob)].name;
  if (name.starts_with("tower_radius")) {
    turned -= build.model.radius_mm[2] - drawn.model.radius_mm[2];
  }
  if (name.starts_with("tower_angle")) {
    turned -= build.model.angle_rad[2] - drawn.model.angle_rad[2];
  }
  if (name.starts_with("tower_twist")) {
    const auto i = static_cast<std::size_t>(knob - kTwistKnob);
    turned -=
        drawn.twist_per_angle * (build.model.angle_rad[i] - drawn.model.angle_rad[i]);
  }
  return turned / kDeltaKnobs[static_cast<std::size_t>(knob)].per_unit;
}

std::vector<int> FirmwareKnobs() {
  return {0, 1, 2, 3, 4, 5, 27, 28};
}

std::vector<int> MachineKnobs() {
  constexpr int kNumMachine = 29;
  std::vector<int> knobs(kNumMachine);
  std::iota(knobs.begin(), knobs.end(), 0);
  return knobs;
}

}  // namespace caltwin
