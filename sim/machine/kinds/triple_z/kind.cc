#include <array>
#include <cmath>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 1> kWhole = {""};
constexpr std::array<std::string_view, 1> kHeight = {"z"};
constexpr std::array<std::string_view, 3> kScrews = {"z1", "z2", "z3"};
constexpr std::array<std::string_view, 2> kLevel = {"x", "y"};
constexpr std::array<std::string_view, 1> kSag = {"EZY"};
constexpr std::array<std::string_view, 3> kTurns = {"EBY", "EAZ", "EBZ"};
constexpr std::array<std::string_view, 5> kWirings = {
    "z1z2", "z1z3", "z2z3", "z1z2z3", "z1z3z2"};
constexpr std::array<std::string_view, 2> kBodies = {"frame", "bed"};
constexpr std::array<std::string_view, 8> kChannels = {
    "x", "y", "z", "z1", "z2", "z3", "probe", "bed"};
constexpr std::array kEffects = {
    KindEffect{"steps_per_mm", kHeight},    KindEffect{"backlash", kHeight},
    KindEffect{"missed_steps", kScrews},    KindEffect{"straightness", kSag},
    KindEffect{"angular", kTurns},          KindEffect{"gantry_sag", kWhole},
    KindEffect{"axis_twist", kWhole},       KindEffect{"pitch_progressive", kScrews},
    KindEffect{"screw_pitch", kScrews},     KindEffect{"screw_cyclic", kScrews},
    KindEffect{"screw_backlash", kScrews},  KindEffect{"pivot_position", kScrews},
    KindEffect{"motors_swapped", kWirings}, KindEffect{"overconstrained_bed", kWhole},
    KindEffect{"frame_growth", kWhole},     KindEffect{"frame_temperature", kBodies},
    KindEffect{"random_walk", kWhole},      KindEffect{"probe_temperature", kWhole},
    KindEffect{"trigger_latency", kWhole},  KindEffect{"trigger_scatter", kWhole},
    KindEffect{"bed_tilt", kWhole},         KindEffect{"bed_bowl", kWhole},
    KindEffect{"bed_cylinder", kLevel},     KindEffect{"bed_twist", kWhole},
    KindEffect{"unknown", kChannels}};

// Belts along x and y, and along z the screws: the nozzle over a bed of 235 mm.
void ReadTripleZAxes(YamlMap* map, Machine* machine) {
  TripleZDrawing& triple_z = TripleZOf(*machine);
  AxisDrawing belt{.max_mm = 235,
                   .lead_mm = 40,
                   .is_belt = true,
                   .max_feed_mm_s = 200,
                   .acceleration_mm_s2 = 3000,
                   .moving_mass_kg = 0.5,
                   .rail_friction_n = 2};
  const ScrewDrawing& first = triple_z.screws[0];
  AxisDrawing screw{.max_mm = triple_z.top_mm,
                    .home = HomeEnd::kMax,
                    .lead_mm = first.lead_mm,
                    .full_steps_per_rev = first.full_steps_per_rev,
                    .microsteps = first.microsteps,
                    .max_feed_mm_s = 20,
                    .acceleration_mm_s2 = 200,
                    .moving_mass_kg = 2,
                    .rail_friction_n = 5};
  // Nothing hangs on a gap: every screw's is in its drive.
  screw.counterbalance_n = screw.moving_mass_kg * kGravity_m_s2;
  machine->axes = {belt, belt, screw};
  if (const auto axes = map->Optional("axes")) {
    YamlMap by_axis = axes->Map();
    for (const Axis axis : kAxes) {
      AxisDrawing& read = machine->axes[static_cast<std::size_t>(Index(axis))];
      if (const auto drawing = by_axis.Optional(Name(axis))) {
        read = ReadAxis(axis, drawing->Map(), read, /*needs_lead=*/false);
      }
    }
    by_axis.NoMoreKeys();
  }
  // Commanded heights count from where the bed meets the nozzle.
  machine->axes[2].home = HomeEnd::kMax;
  triple_z.top_mm = machine->axes[2].max_mm;
}

// Belts move the nozzle along x and y, three screws the bed along z.
class TripleZ final : public MachineKind {
 public:
  std::string_view name() const override { return "triple_z"; }
  std::string_view about() const override {
    return "A printer whose bed stands on three screws z1, z2 and z3, each with a "
           "motor. "
           "`caltwin run` and `calibrate` level one by G-code, `serve` is one, "
           "`simulate`, "
           "`diagnose` and `plan` measure one, `compare levelling` sets rival "
           "procedures "
           "beside each other.";
  }
  std::string_view where() const override { return " on a triple-Z printer"; }
  bool bed_is_on_screws() const override { return true; }
  std::span<const std::string_view> motors() const override { return kScrews; }
  std::span<const KindEffect> effects() const override { return kEffects; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    machine->own = ReadTripleZDrawing(map);
  }

  void ReadAxes(YamlMap* map, Machine* machine) const override {
    ReadTripleZAxes(map, machine);
  }

  std::vector<DrawnDrive> Drives(const Machine& machine) const override {
    auto drives = MachineKind::Drives(machine);
    const auto* drawing = machine.Own<TripleZDrawing>();
    for (int i = 0; drawing != nullptr && i < kNumScrews; ++i) {
      const ScrewDrawing& screw = drawing->screws[static_cast<std::size_t>(i)];
      drives.push_back(
          {ScrewName(i), screw.lead_mm, /*is_belt=*/false, screw.full_steps_per_rev});
    }
    return drives;
  }

  std::optional<Vec3<double>> Motors_mm(const Machine& machine,
                                        const Vec3<double>& q_mm,
                                        const Vec3<double>& raised_mm) const override {
    Vec3<double> told_mm;
    for (int i = 0; i < kNumScrews; ++i) {
      told_mm[i] = TripleZOf(machine).top_mm - q_mm[2] + raised_mm[i];
    }
    return told_mm;
  }

  // As the nozzle's height over the bed grows, the screws go down.
  std::optional<Vec3<double>> MotorSenses(const Machine&,
                                          const Vec3<double>& from_mm,
                                          const Vec3<double>& to_mm) const override {
    const double up_mm = to_mm[2] - from_mm[2];
    const double sense = std::abs(up_mm) < kStill_mm ? 0 : std::copysign(1, up_mm);
    return Vec3<double>::Constant(-sense);
  }
};

}  // namespace

const MachineKind* TripleZKind() {
  static const TripleZ kind;
  return &kind;
}

}  // namespace caltwin
