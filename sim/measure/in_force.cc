#include "sim/measure/in_force.h"

namespace caltwin {
namespace {

void Take(const std::map<std::string, double>& stated, std::array<double, 3>* values) {
  for (const auto& [name, value] : stated) {
    if (const auto axis = AxisNamed(name)) {
      (*values)[static_cast<std::size_t>(Index(*axis))] = value;
    }
  }
}

}  // namespace

Settings InForce(const DataHeader& header,
                 const Machine& machine,
                 const std::string& id) {
  Settings settings = machine.settings;
  if (header.tip_radius_mm) settings.tip_radius_mm = *header.tip_radius_mm;
  const auto stated = header.settings.find(id);
  if (stated == header.settings.end()) return settings;
  Take(stated->second.steps_per_mm, &settings.steps_per_mm);
  Take(stated->second.backlash_mm, &settings.backlash_mm);
  Take(stated->second.probe_deflection_mm, &settings.probe_deflection_mm);
  if (stated->second.tip_radius_mm) {
    settings.tip_radius_mm = *stated->second.tip_radius_mm;
  }
  return settings;
}

SettingsInForce AsHeader(const Settings& settings) {
  SettingsInForce in_force{.tip_radius_mm = settings.tip_radius_mm};
  for (const Axis axis : kAxes) {
    const auto i = static_cast<std::size_t>(Index(axis));
    in_force.steps_per_mm[Name(axis)] = settings.steps_per_mm[i];
    in_force.backlash_mm[Name(axis)] = settings.backlash_mm[i];
    in_force.probe_deflection_mm[Name(axis)] = settings.probe_deflection_mm[i];
  }
  return in_force;
}

}  // namespace caltwin
