#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 1> kWhole = {""};
constexpr std::array<std::string_view, 3> kTowers = {"a", "b", "c"};
constexpr std::array<std::string_view, 2> kLevel = {"x", "y"};
constexpr std::array<std::string_view, 9> kRods = {
    "a", "b", "c", "a1", "a2", "b1", "b2", "c1", "c2"};
constexpr std::array<std::string_view, 2> kBodies = {"frame", "bed"};
constexpr std::array<std::string_view, 8> kChannels = {
    "x", "y", "z", "a", "b", "c", "probe", "bed"};
constexpr std::array kEffects = {
    KindEffect{"pulley_eccentric", kTowers},  KindEffect{"missed_steps", kTowers},
    KindEffect{"pitch_progressive", kTowers}, KindEffect{"homing_scatter", kTowers},
    KindEffect{"belt_pitch", kTowers},        KindEffect{"carriage_backlash", kTowers},
    KindEffect{"rod_mismatch", kRods},        KindEffect{"tower_lean", kTowers},
    KindEffect{"tower_twist", kTowers},       KindEffect{"tower_radius", kTowers},
    KindEffect{"effector_tilt", kWhole},      KindEffect{"frame_growth", kWhole},
    KindEffect{"frame_temperature", kBodies}, KindEffect{"random_walk", kWhole},
    KindEffect{"probe_temperature", kWhole},  KindEffect{"trigger_latency", kWhole},
    KindEffect{"trigger_scatter", kWhole},    KindEffect{"bed_tilt", kWhole},
    KindEffect{"bed_bowl", kWhole},           KindEffect{"bed_cylinder", kLevel},
    KindEffect{"bed_twist", kWhole},          KindEffect{"unknown", kChannels}};

// A belt of 20 teeth of 2 mm, down from the endstop.
AxisDrawing TowerAxis(const DeltaDrawing& delta, std::size_t tower) {
  return {.min_mm = 0,
          .max_mm = delta.model.endstop_mm[tower] + delta.model.arm_mm[tower] / 4,
          .home = HomeEnd::kMin,
          .lead_mm = 40,
          .is_belt = true,
          .max_feed_mm_s = 200,
          .acceleration_mm_s2 = 2000,
          .moving_mass_kg = 0.15,
          .rail_friction_n = 6};
}

// Three towers, three rods of two each: the tip follows the carriages by the chain.
class Delta final : public MachineKind {
 public:
  std::string_view name() const override { return "delta"; }
  std::string_view about() const override {
    return "Three carriages on towers a, b and c (210, 330 and 90 deg), six rods in "
           "pairs, "
           "an effector that hangs on them. `caltwin run` and `calibrate` calibrate "
           "one by "
           "G-code, `serve` is one, `simulate`, `diagnose` and `plan` measure one, "
           "`compare "
           "delta` sets rival procedures beside each other, `import klipper-delta` "
           "reads a "
           "real one.";
  }
  std::string_view where() const override { return " on a delta"; }
  bool moves_along_axes() const override { return false; }
  std::span<const std::string_view> motors() const override { return kTowers; }
  std::span<const KindEffect> effects() const override { return kEffects; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    machine->own = ReadDeltaDrawing(map);
  }

  // Its towers are alike but where they are named.
  void ReadAxes(YamlMap* map, Machine* machine) const override {
    const DeltaDrawing& delta = DeltaOf(*machine);
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      machine->axes[i] = TowerAxis(delta, i);
    }
    const auto axes = map->Optional("axes");
    if (!axes) return;
    YamlMap by_tower = axes->Map();
    for (int i = 0; i < kNumTowers; ++i) {
      const auto drawing = by_tower.Optional(TowerName(i));
      if (!drawing) continue;
      // What hangs on a tower's gap depends on the pose (TowerLoad_n).
      AxisDrawing& read = machine->axes[static_cast<std::size_t>(i)];
      read = ReadAxis(Axis::kX, drawing->Map(), read, /*needs_lead=*/false);
    }
    by_tower.NoMoreKeys();
  }

  // Its nozzle touches, unless a probe is stated. It does not give way; a nanometre
  // keeps the quotients of Pretravel_mm finite.
  ProbeDrawing ProbeAsDrawn() const override {
    constexpr double kRigid_mm = 1e-6;
    return {.pretravel_mm = kRigid_mm, .hysteresis_mm = 0};
  }

  void ReadSettings(YamlMap* map, Machine* machine) const override {
    DeltaDrawing& delta = DeltaOf(*machine);
    ReadByTower(map, "steps_per_mm", {1e-3, 1e7}, &machine->settings.steps_per_mm);
    ReadDeltaSettings(map, delta.model, &delta.settings);
    map->NoMoreKeys();
  }

  std::vector<DrawnDrive> Drives(const Machine& machine) const override {
    auto drives = MachineKind::Drives(machine);
    for (int i = 0; i < kNumTowers; ++i) {
      drives[static_cast<std::size_t>(i)].name = TowerName(i);
    }
    return drives;
  }

  Homed AtHome(const Machine& machine) const override {
    Homed homed{.q_mm = {0, 0, DeltaOf(machine).settings.endstop_mm[0]},
                .sense = {0, 0, 1},
                .motor_sense = Vec3<double>::Constant(-1)};
    homed.since_rev_mm.setConstant(homed.q_mm[2] / 2);
    return homed;
  }

  Vec3<double> Middle_mm(const Machine&) const override { return Vec3<double>::Zero(); }
  double TipBelowJoints_mm(const Machine& machine) const override {
    const auto* drawing = machine.Own<DeltaDrawing>();
    return drawing == nullptr ? 0 : drawing->joint_height_mm;
  }

  std::optional<OutOfReach> WhyNotAt(const Machine& machine,
                                     const Vec3<double>& q_mm) const override {
    const Vec3<double> motors_mm = DeltaMotors_mm(DeltaOf(machine).settings, q_mm);
    if (motors_mm.allFinite() && (motors_mm.array() > 0).all()) return std::nullopt;
    return OutOfReach{
        fmt::format("would take the nozzle to ({:.3f}, {:.3f}, {:.3f}) mm, beyond what "
                    "its rods reach",
                    q_mm[0],
                    q_mm[1],
                    q_mm[2]),
        "choose a smaller radius or height"};
  }

  std::optional<Vec3<double>> Motors_mm(const Machine& machine,
                                        const Vec3<double>& q_mm,
                                        const Vec3<double>&) const override {
    return DeltaMotors_mm(DeltaOf(machine).settings, q_mm);
  }

  // At the end of the move: a carriage may turn back within it.
  std::optional<Vec3<double>> MotorSenses(const Machine& machine,
                                          const Vec3<double>& from_mm,
                                          const Vec3<double>& to_mm) const override {
    constexpr double kLast_mm = 0.01;
    const DeltaModel<double>& settings = DeltaOf(machine).settings;
    const Vec3<double> travel_mm = to_mm - from_mm;
    const double length_mm = travel_mm.norm();
    const Vec3<double> just_before_mm =
        to_mm - travel_mm * (std::min(kLast_mm, length_mm) / length_mm);
    const Vec3<double> moved_mm =
        DeltaMotors_mm(settings, to_mm) - DeltaMotors_mm(settings, just_before_mm);
    Vec3<double> senses;
    for (int i = 0; i < kNumTowers; ++i) {
      senses[i] = std::abs(moved_mm[i]) < kStill_mm ? 0 : std::copysign(1, moved_mm[i]);
    }
    return senses;
  }
};

}  // namespace

const MachineKind* DeltaKind() {
  static const Delta kind;
  return &kind;
}

}  // namespace caltwin
