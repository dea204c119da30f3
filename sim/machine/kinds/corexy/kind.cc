#include <array>

#include "sim/machine/kinds/corexy/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 2> kBelts = {"a", "b"};
constexpr std::array<std::string_view, 3> kDrives = {"a", "b", "z"};
constexpr std::array<std::string_view, 1> kScrew = {"z"};
constexpr std::array<std::string_view, 1> kWhole = {""};
constexpr std::array<std::string_view, 7> kChannels = {
    "x", "y", "z", "a", "b", "probe", "bed"};
constexpr Names kNone{};
constexpr std::array<std::string_view, 2> kGauges = {"corexy", "cartesian"};
constexpr std::array<std::string_view, 3> kGaugesAndBed = {
    "corexy", "cartesian", "triple_z"};

// What differs from a cartesian machine: what its drives do, and its beam.
constexpr std::array kEffects = {KindEffect{"steps_per_mm", kDrives},
                                 KindEffect{"backlash", kDrives},
                                 KindEffect{"windup_load", kNone},
                                 KindEffect{"cyclic_lead", kScrew},
                                 KindEffect{"pulley_eccentric", kBelts},
                                 KindEffect{"microstep", kDrives},
                                 KindEffect{"pitch_progressive", kScrew},
                                 KindEffect{"pitch_map", kScrew},
                                 KindEffect{"backlash_worn", kScrew},
                                 KindEffect{"reversal_spike", kNone},
                                 KindEffect{"thermal_screw", kScrew},
                                 KindEffect{"missed_steps", kDrives},
                                 KindEffect{"belt_pitch", kBelts},
                                 KindEffect{"racking", kWhole},
                                 KindEffect{"servo_mismatch", kNone},
                                 KindEffect{"servo_lag", kNone},
                                 KindEffect{"unknown", kChannels}};

//   a = x + y,  b = x - y
const DriveMap& Belts() {
  static const DriveMap map = [] {
    DriveMap belts{.names = kDrives};
    belts.drives_by_axis << 1, 1, 0, 1, -1, 0, 0, 0, 1;
    belts.axes_by_drive << 0.5, 0.5, 0, 0.5, -0.5, 0, 0, 0, 1;
    return belts;
  }();
  return map;
}

// What a belt's motor and pulley are, over what the axis of its place says.
void ReadBelt(YamlMap map, AxisDrawing* drive) {
  drive->is_belt = true;
  drive->lead_mm = map.NumberOr(
      "pulley_mm_per_rev", drive->lead_mm, {1e-3, 1e4}, "travel per motor turn");
  drive->full_steps_per_rev =
      map.NumberOr("full_steps_per_rev", drive->full_steps_per_rev, {1, 1e6});
  drive->microsteps = map.NumberOr("microsteps", drive->microsteps, {1, 4096});
  map.NoMoreKeys();
}

// A gantry that hangs on a motor of Z at each corner.
void ReadCorners(YamlMap gantry, Machine* machine) {
  const auto corners = gantry.Required("corners_mm");
  gantry.NoMoreKeys();
  if (!corners) return;
  constexpr double kFar_mm = 1e5, kLeast_mm = 10;
  const std::size_t faults = corners->faults()->size();
  const auto list = corners->List();
  if (corners->faults()->size() != faults) return;
  if (list.size() != 2) {
    corners->Fail("are not two places", "as in `corners_mm: [[-60, -10], [360, 370]]`");
    return;
  }
  const auto low = list[0].Numbers(2, {-kFar_mm, kFar_mm});
  const auto high = list[1].Numbers(2, {-kFar_mm, kFar_mm});
  if (corners->faults()->size() != faults) return;
  if (high[0] - low[0] < kLeast_mm || high[1] - low[1] < kLeast_mm) {
    corners->Fail("have the second not 10 mm or more behind and right of the first",
                  "the corner of the motor `stepper_z` first");
    return;
  }
  machine->own = CornersDrawing{{low[0], low[1]}, {high[0], high[1]}};
}

// Two belts, A and B, move the head: A alone along one diagonal, B alone along the
// other. What `axes.x` says of pulley and motor is A's, `axes.y` B's, as in Klipper's
// [stepper_x] and [stepper_y]; `axes.a` and `axes.b` may say so too.
class CoreXy : public MachineKind {
 public:
  std::string_view name() const override { return "corexy"; }
  std::string_view about() const override {
    return "A printer whose two belts, A and B, move the head together: A alone along "
           "one "
           "diagonal, B along the other; its bed on one Z, or with `screws:` on three. "
           "`caltwin run` and `calibrate` calibrate one by G-code, `serve` is one, "
           "`simulate`, `diagnose` and `plan` measure one.";
  }
  std::string_view where() const override { return " on a CoreXY"; }
  std::span<const std::string_view> plans_as() const override { return kGauges; }
  bool touches_with_nozzle() const override { return false; }
  const DriveMap* drive_map() const override { return &Belts(); }
  std::span<const std::string_view> motors() const override { return kBelts; }
  std::span<const KindEffect> effects() const override { return kEffects; }
  bool has_other_effects() const override { return true; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    if (map->Has("screws")) {
      machine->kind = CoreXyOnScrewsKind();
      machine->kind->ReadDrawing(map, machine);
    } else if (const auto gantry = map->Optional("gantry")) {
      ReadCorners(gantry->Map(), machine);
    }
  }
  void ReadAxes(YamlMap* map, Machine* machine) const override {
    const auto axes = map->Required("axes");
    if (!axes) return;
    const AxisDrawing usual{
        .lead_mm = 40, .is_belt = true, .max_feed_mm_s = 300, .rail_friction_n = 5};
    YamlMap by_axis = axes->Map();
    for (const Axis axis : kAxes) {
      const auto drawing = by_axis.Required(Name(axis));
      if (!drawing) continue;
      const bool is_z = axis == Axis::kZ;
      machine->axes[static_cast<std::size_t>(Index(axis))] = ReadAxis(
          axis, drawing->Map(), is_z ? AxisDrawing{} : usual, /*needs_lead=*/is_z);
    }
    for (std::size_t i = 0; i < kBelts.size(); ++i) {
      if (const auto belt = by_axis.Optional(std::string(kBelts[i]))) {
        ReadBelt(belt->Map(), &machine->axes[i]);
      }
    }
    by_axis.NoMoreKeys();
  }
};

constexpr std::array<std::string_view, 3> kScrews = {"z1", "z2", "z3"};
constexpr std::array<std::string_view, 5> kWirings = {
    "z1z2", "z1z3", "z2z3", "z1z2z3", "z1z3z2"};
constexpr std::array<std::string_view, 5> kMissing = {"a", "b", "z1", "z2", "z3"};
constexpr std::array<std::string_view, 10> kAllChannels = {
    "x", "y", "z", "a", "b", "z1", "z2", "z3", "probe", "bed"};
constexpr std::array<std::string_view, 2> kLevel = {"x", "y"};
constexpr std::array<std::string_view, 3> kBelow = {"EYX", "EXY", "EZY"};
constexpr std::array<std::string_view, 3> kTurns = {"EBY", "EAZ", "EBZ"};
constexpr std::array<std::string_view, 1> kPlane = {"C0Y"};
constexpr std::array<std::string_view, 2> kBodies = {"frame", "bed"};
constexpr std::array kOnScrews = {KindEffect{"steps_per_mm", kDrives},
                                  KindEffect{"backlash", kDrives},
                                  KindEffect{"pulley_eccentric", kBelts},
                                  KindEffect{"microstep", kBelts},
                                  KindEffect{"missed_steps", kMissing},
                                  KindEffect{"belt_pitch", kBelts},
                                  KindEffect{"racking", kWhole},
                                  KindEffect{"squareness", kPlane},
                                  KindEffect{"straightness", kBelow},
                                  KindEffect{"angular", kTurns},
                                  KindEffect{"gantry_sag", kWhole},
                                  KindEffect{"axis_twist", kWhole},
                                  KindEffect{"screw_pitch", kScrews},
                                  KindEffect{"screw_cyclic", kScrews},
                                  KindEffect{"screw_backlash", kScrews},
                                  KindEffect{"pivot_position", kScrews},
                                  KindEffect{"pitch_progressive", kScrews},
                                  KindEffect{"motors_swapped", kWirings},
                                  KindEffect{"overconstrained_bed", kWhole},
                                  KindEffect{"frame_growth", kWhole},
                                  KindEffect{"frame_temperature", kBodies},
                                  KindEffect{"random_walk", kWhole},
                                  KindEffect{"probe_temperature", kWhole},
                                  KindEffect{"trigger_latency", kWhole},
                                  KindEffect{"trigger_scatter", kWhole},
                                  KindEffect{"bed_tilt", kWhole},
                                  KindEffect{"bed_bowl", kWhole},
                                  KindEffect{"bed_cylinder", kLevel},
                                  KindEffect{"bed_twist", kWhole},
                                  KindEffect{"unknown", kAllChannels}};

// The same belts over a bed on three screws, each with a motor: the screws, and how the
// file gives them, are a triple-Z printer's.
class CoreXyOnScrews final : public CoreXy {
 public:
  std::string_view where() const override { return " on a CoreXY over screws"; }
  std::span<const std::string_view> plans_as() const override { return kGaugesAndBed; }
  bool touches_with_nozzle() const override { return true; }
  bool bed_is_on_screws() const override { return true; }
  std::span<const KindEffect> effects() const override { return kOnScrews; }
  bool has_other_effects() const override { return false; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    TripleZKind()->ReadDrawing(map, machine);
  }
  void ReadAxes(YamlMap* map, Machine* machine) const override {
    TripleZKind()->ReadAxes(map, machine);
  }
  std::optional<Vec3<double>> Screws_mm(const Machine& machine,
                                        const Vec3<double>& q_mm,
                                        const Vec3<double>& raised_mm) const override {
    return TripleZKind()->Motors_mm(machine, q_mm, raised_mm);
  }
  std::vector<DrawnDrive> Drives(const Machine& machine) const override {
    auto drives = CoreXy::Drives(machine);
    for (const DrawnDrive& drive : TripleZKind()->Drives(machine)) {
      if (drive.name.size() == 2) drives.push_back(drive);  // z1 z2 z3
    }
    return drives;
  }
};

}  // namespace

const MachineKind* CoreXyOnScrewsKind() {
  static const CoreXyOnScrews kind;
  return &kind;
}

const MachineKind* CoreXyKind() {
  static const CoreXy kind;
  return &kind;
}

}  // namespace caltwin
