#include "sim/machine/machine_kind.h"

#include <cmath>

#include <fmt/format.h>

namespace caltwin {

AxisDrawing ReadAxis(Axis axis, YamlMap map, AxisDrawing drawing, bool needs_lead) {
  drawing.min_mm = map.NumberOr("min_mm", 0, {-1e5, 1e5});
  drawing.max_mm = map.Number("max_mm", {-1e5, 1e5});
  if (drawing.max_mm <= drawing.min_mm) {
    map.faults()->Add(map.place(),
                      fmt::format("{}: max_mm = {} is not above min_mm = {}",
                                  map.path(),
                                  drawing.max_mm,
                                  drawing.min_mm));
  }
  const std::string home =
      map.WordOr("home", axis == Axis::kZ ? "max" : "min", {"min", "max"});
  drawing.home = home == "min" ? HomeEnd::kMin : HomeEnd::kMax;
  const bool has_pulley = map.Has("pulley_mm_per_rev");
  const bool has_lead = map.Has("lead_mm");
  if (has_pulley && has_lead) {
    map.faults()->Add(map.place(),
                      map.path() + " has both lead_mm and pulley_mm_per_rev",
                      "a screw has a lead, a belt a pulley: keep one");
  }
  if (has_pulley || has_lead || needs_lead) {
    drawing.is_belt = has_pulley;
    drawing.lead_mm = map.Number(has_pulley ? "pulley_mm_per_rev" : "lead_mm",
                                 {1e-3, 1e4},
                                 "travel per motor turn");
  }
  drawing.full_steps_per_rev =
      map.NumberOr("full_steps_per_rev", drawing.full_steps_per_rev, {1, 1e6});
  drawing.microsteps = map.NumberOr("microsteps", drawing.microsteps, {1, 4096});
  drawing.max_feed_mm_s =
      map.NumberOr("max_feed_mm_s", drawing.max_feed_mm_s, {1e-3, 1e4});
  drawing.acceleration_mm_s2 =
      map.NumberOr("acceleration_mm_s2", drawing.acceleration_mm_s2, {1e-3, 1e6});
  drawing.moving_mass_kg =
      map.NumberOr("moving_mass_kg", drawing.moving_mass_kg, {0.01, 1e5});
  drawing.rail_friction_n =
      map.NumberOr("rail_friction_n", drawing.rail_friction_n, {0, 1e5});
  const double weight_n = drawing.moving_mass_kg * kGravity_m_s2;
  drawing.counterbalance_n =
      axis == Axis::kZ ? map.NumberOr("counterbalance_n", weight_n, {0, 1e6}) : 0;
  map.NoMoreKeys();
  return drawing;
}

namespace {

// In which sense each drive goes; of one that has no motor column nobody knows.
Vec3<double> SensesOf(const MachineKind& kind, const Vec3<double>& by_axis) {
  const Vec3<double> by_drive = DrivesOf(kind.drive_map(), by_axis);
  Vec3<double> senses = Vec3<double>::Constant(std::nan(""));
  for (int i = 0; i < static_cast<int>(kind.motors().size()); ++i) {
    const bool stands = std::abs(by_drive[i]) <= kStill_mm;
    senses[i] = stands ? 0 : std::copysign(1, by_drive[i]);
  }
  return senses;
}

}  // namespace

void MachineKind::ReadDrawing(YamlMap*, Machine*) const {}

void MachineKind::ReadAxes(YamlMap* map, Machine* machine) const {
  const auto axes = map->Required("axes");
  if (!axes) return;
  YamlMap by_axis = axes->Map();
  for (const Axis axis : kAxes) {
    if (const auto drawing = by_axis.Required(Name(axis))) {
      machine->axes[static_cast<std::size_t>(Index(axis))] =
          ReadAxis(axis, drawing->Map(), {}, /*needs_lead=*/true);
    }
  }
  by_axis.NoMoreKeys();
}

void MachineKind::ReadSettings(YamlMap* map, Machine* machine) const {
  caltwin::ReadSettings(map, *this, &machine->settings);
}

std::vector<DrawnDrive> MachineKind::Drives(const Machine& machine) const {
  std::vector<DrawnDrive> drives;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    drives.push_back({DriveName(drive_map(), Index(axis)),
                      drawing.lead_mm,
                      drawing.is_belt,
                      drawing.full_steps_per_rev});
  }
  return drives;
}

Homed MachineKind::AtHome(const Machine& machine) const {
  Homed homed;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    const int i = Index(axis);
    homed.q_mm[i] = drawing.home_mm();
    homed.sense[i] = drawing.home == HomeEnd::kMin ? -1 : 1;
    homed.since_rev_mm[i] = drawing.travel_mm() / 2;
  }
  // Y is homed last, by all drives that move it.
  if (drive_map() != nullptr) {
    homed.motor_sense = SensesOf(*this, {0, homed.sense[1], 0});
  }
  return homed;
}

Vec3<double> MachineKind::Middle_mm(const Machine& machine) const {
  return {machine.axis(Axis::kX).mid_mm(),
          machine.axis(Axis::kY).mid_mm(),
          machine.axis(Axis::kZ).mid_mm()};
}

std::optional<OutOfReach> MachineKind::WhyNotAt(const Machine& machine,
                                                const Vec3<double>& q_mm) const {
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    const double q = q_mm[Index(axis)];
    if (q >= drawing.min_mm - kStill_mm && q <= drawing.max_mm + kStill_mm) continue;
    return OutOfReach{
        fmt::format("would take {} to {:.3f} mm, beyond its travel of {} to {} mm",
                    Name(axis),
                    q,
                    drawing.min_mm,
                    drawing.max_mm),
        "choose another place or a smaller extent"};
  }
  return std::nullopt;
}

std::optional<Vec3<double>> MachineKind::Motors_mm(const Machine&,
                                                   const Vec3<double>& q_mm,
                                                   const Vec3<double>&) const {
  if (drive_map() == nullptr) return std::nullopt;
  Vec3<double> told_mm = DrivesOf(drive_map(), q_mm);
  for (int i = static_cast<int>(motors().size()); i < 3; ++i) {
    told_mm[i] = std::nan("");  // An axis of its own.
  }
  return told_mm;
}

std::optional<Vec3<double>> MachineKind::Screws_mm(const Machine&,
                                                   const Vec3<double>&,
                                                   const Vec3<double>&) const {
  return std::nullopt;
}

double MachineKind::TipBelowJoints_mm(const Machine&) const {
  return 0;
}

std::optional<Vec3<double>> MachineKind::MotorSenses(const Machine&,
                                                     const Vec3<double>& from_mm,
                                                     const Vec3<double>& to_mm) const {
  if (drive_map() == nullptr) return std::nullopt;
  return SensesOf(*this, to_mm - from_mm);
}

}  // namespace caltwin
