#include "sim/measure/in_force.h"

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

void Take(const std::map<std::string, double>& stated,
          const DriveMap* drives,
          std::array<double, 3>* values) {
  for (const auto& [name, value] : stated) {
    if (const auto drive = DriveIndex(drives, name)) {
      (*values)[static_cast<std::size_t>(*drive)] = value;
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
  const DriveMap* drives = machine.kind->drive_map();
  Take(stated->second.steps_per_mm, drives, &settings.steps_per_mm);
  Take(stated->second.backlash_mm, drives, &settings.backlash_mm);
  Take(stated->second.probe_deflection_mm, nullptr, &settings.probe_deflection_mm);
  if (stated->second.tip_radius_mm) {
    settings.tip_radius_mm = *stated->second.tip_radius_mm;
  }
  return settings;
}

SettingsInForce AsHeader(const Settings& settings, const MachineKind& kind) {
  SettingsInForce in_force{.tip_radius_mm = settings.tip_radius_mm};
  for (const Axis axis : kAxes) {
    const auto i = static_cast<std::size_t>(Index(axis));
    const std::string drive = DriveName(kind.drive_map(), Index(axis));
    in_force.steps_per_mm[drive] = settings.steps_per_mm[i];
    in_force.backlash_mm[drive] = settings.backlash_mm[i];
    in_force.probe_deflection_mm[Name(axis)] = settings.probe_deflection_mm[i];
  }
  return in_force;
}

}  // namespace caltwin
