#include "sim/measure/import/klipper_geometry.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kLongest_mm = 10'000;
constexpr double kFullSteps = 200;  // Klipper's default.
constexpr std::array kAngles_deg = {210.0, 330.0, 90.0};

std::string SectionOf(int tower) {
  return "stepper_" + TowerName(tower);
}

std::string_view WithoutBlanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// `80:16` as 5; nullopt for what is no gear.
std::optional<double> GearOf(std::string_view pair) {
  const std::size_t colon = pair.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto turns = NumberOf(WithoutBlanks(pair.substr(0, colon)));
  const auto by = NumberOf(WithoutBlanks(pair.substr(colon + 1)));
  if (turns.value_or(0) <= 0 || by.value_or(0) <= 0) return std::nullopt;
  return turns.value_or(1) / by.value_or(1);
}

}  // namespace

double GearRatioOf(const PrinterCfg& cfg, const std::string& section, Faults* faults) {
  const CfgSetting* setting = cfg.Find(section, "gear_ratio");
  if (setting == nullptr || setting->value.text.empty()) return 1;
  std::optional<double> ratio = 1;
  std::string_view rest = setting->value.text;
  while (ratio) {
    const std::string_view pair = rest.substr(0, rest.find(','));
    const auto gear = GearOf(pair);
    ratio = gear ? std::optional(*ratio * *gear) : std::nullopt;
    if (pair.size() == rest.size()) break;
    rest.remove_prefix(pair.size() + 1);
  }
  if (ratio && *ratio > 1e-4 && *ratio < 1e4) return *ratio;
  faults->Add(PlaceOf(setting->value, cfg.name()),
              fmt::format("[{}] gear_ratio = '{}'", section, setting->value.text),
              "teeth apart by a colon, gears apart by commas: 80:16, 57:11");
  return 1;
}

namespace {

KlipperDrive DriveOf(const PrinterCfg& cfg,
                     int tower,
                     std::optional<double> step_mm,
                     Faults* faults) {
  const std::string section = SectionOf(tower);
  const auto number = [&](const char* key, double min, double max) {
    return cfg.Number(section, key, min, max, faults);
  };
  const auto turn_mm = number("rotation_distance", 1e-3, 1e4);
  const auto microsteps = number("microsteps", 1, 1024);
  const auto full_steps = number("full_steps_per_rotation", 1, 10'000);
  const auto stated_mm = number("step_distance", 1e-7, 1);
  KlipperDrive drive;
  if (turn_mm) {
    drive.rotation_distance_mm = *turn_mm;
    drive.full_steps_per_mm =
        full_steps.value_or(kFullSteps) * GearRatioOf(cfg, section, faults) / *turn_mm;
  }
  if (microsteps) drive.microsteps = *microsteps;
  if (step_mm) {
    drive.step_mm = *step_mm;
  } else if (turn_mm && microsteps) {
    drive.step_mm = 1 / (drive.full_steps_per_mm * *microsteps);
  } else if (stated_mm) {
    drive.step_mm = *stated_mm;
  }
  constexpr double kShortest_mm = 1e-7, kLongestStep_mm = 10;
  if (drive.step_mm < kShortest_mm || drive.step_mm > kLongestStep_mm) {
    faults->Add(
        cfg.PlaceOfSection(section),
        fmt::format("[{}] a motor step of {:g} mm", section, drive.step_mm),
        "rotation_distance / (full_steps_per_rotation * microsteps * gear_ratio) "
        "is a few micrometres to a few hundredths of a millimetre");
    drive.step_mm = kUnknown;
  }
  return drive;
}

/// Of tower a, b or c; else tower a's where it is inherited; else a fault.
double LengthOf(const PrinterCfg& cfg, int tower, const char* key, Faults* faults) {
  for (const int of : {tower, 0}) {
    if (cfg.Find(SectionOf(of), key) == nullptr) continue;
    return cfg.Number(SectionOf(of), key, 1e-3, kLongest_mm, faults).value_or(kUnknown);
  }
  if (tower == 0) {
    faults->Add(cfg.PlaceOfSection(SectionOf(0)),
                fmt::format("[stepper_a] {} is not stated", key),
                "what the towers measured cannot be made a height without it");
  }
  return kUnknown;
}

/// Travel of a carriage down to where the nozzle touches the bed's rim opposite its
/// tower; without a printable radius, six tenths of the delta radius.
double LowestTravel_mm(const DeltaModel<double>& model,
                       std::size_t tower,
                       double print_radius_mm) {
  constexpr double kUsualReach = 0.6;
  const double arm_mm = model.arm_mm[tower], radius_mm = model.radius_mm[tower];
  const double reach_mm =
      radius_mm + (Known(print_radius_mm) ? print_radius_mm : kUsualReach * radius_mm);
  const double carriage2_mm2 = arm_mm * arm_mm - reach_mm * reach_mm;
  return model.endstop_mm[tower] + std::sqrt(arm_mm * arm_mm - radius_mm * radius_mm) -
         std::sqrt(std::max(carriage2_mm2, 0.0));
}

void CheckKinematics(const PrinterCfg& cfg, KlipperGeometry* geometry, Faults* faults) {
  const CfgSetting* kinematics = cfg.Find("printer", "kinematics");
  if (kinematics == nullptr) {
    geometry->assumed.emplace_back(
        "the machine is a linear delta; the file does not say its kinematics");
  } else if (kinematics->value.text != "delta") {
    faults->Add(PlaceOf(kinematics->value, cfg.name()),
                fmt::format("[printer] kinematics is '{}'", kinematics->value.text),
                "a calibration of three towers belongs to kinematics: delta");
  }
}

}  // namespace

std::optional<KlipperGeometry> ReadKlipperGeometry(const PrinterCfg& cfg,
                                                   std::optional<double> step_mm,
                                                   Faults* faults) {
  const std::size_t before = faults->size();
  KlipperGeometry geometry;
  CheckKinematics(cfg, &geometry, faults);
  const auto radius_mm =
      cfg.Number("printer", "delta_radius", 1e-3, kLongest_mm, faults);
  if (!radius_mm && cfg.Find("printer", "delta_radius") == nullptr) {
    faults->Add(cfg.PlaceOfSection("printer"),
                "[printer] delta_radius is not stated",
                "it is the distance from the tower joints to the effector joints, "
                "horizontally");
  }
  const auto print_radius_mm =
      cfg.Number("printer", "print_radius", 1e-3, kLongest_mm, faults);
  geometry.print_radius_mm = print_radius_mm.value_or(kUnknown);
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    geometry.drive[at] = DriveOf(cfg, i, step_mm, faults);
    geometry.model.radius_mm[at] = radius_mm.value_or(kUnknown);
    geometry.model.arm_mm[at] = LengthOf(cfg, i, "arm_length", faults);
    geometry.model.endstop_mm[at] = LengthOf(cfg, i, "position_endstop", faults);
    geometry.model.angle_rad[at] = RadFromDeg(
        cfg.Number(SectionOf(i), "angle", -360, 720, faults).value_or(kAngles_deg[at]));
    if (faults->size() == before &&
        geometry.model.arm_mm[at] <= geometry.model.radius_mm[at]) {
      faults->Add(
          cfg.PlaceOfSection(SectionOf(i)),
          fmt::format("tower {}: an arm of {:g} mm at a delta radius of {:g} mm",
                      TowerName(i),
                      geometry.model.arm_mm[at],
                      geometry.model.radius_mm[at]),
          "an arm is longer than the delta radius, or the nozzle does not hang "
          "in the middle");
    }
  }
  if (faults->size() != before) return std::nullopt;
  return geometry;
}

std::string DeltaMachineYaml(const DeltaMachineText& text) {
  const DeltaModel<double>& model = text.model;
  const auto of_towers = [](const std::array<double, 3>& values) {
    if (values[0] == values[1] && values[1] == values[2]) {
      return fmt::format("{:.6f}", values[0]);
    }
    return fmt::format(
        "{{a: {:.6f}, b: {:.6f}, c: {:.6f}}}", values[0], values[1], values[2]);
  };
  std::string yaml = fmt::format(
      "# The geometry that {} holds: what the firmware believes, not what was built.\n"
      "# Rod spacing, effector radius and joint height stand in no firmware's "
      "configuration:\n"
      "# the defaults hold until you measure them.\n"
      "format: 1\nname: {}\nkinematics: delta\n\naxes:\n",
      text.source,
      text.name);
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const KlipperDrive& drive = text.drive[at];
    yaml += fmt::format("  {}: {{min_mm: 0, max_mm: {:.3f}, home: min",
                        TowerName(i),
                        LowestTravel_mm(model, at, text.print_radius_mm));
    if (Known(drive.rotation_distance_mm)) {
      yaml += fmt::format(", pulley_mm_per_rev: {:g}", drive.rotation_distance_mm);
      yaml += fmt::format(", full_steps_per_rev: {:g}",
                          drive.full_steps_per_mm * drive.rotation_distance_mm);
    }
    if (Known(drive.microsteps))
      yaml += fmt::format(", microsteps: {:g}", drive.microsteps);
    yaml += "}\n";
  }
  yaml += "\ntowers:\n";
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    yaml += fmt::format("  {}: {{angle_deg: {:.6f}}}\n",
                        TowerName(static_cast<int>(i)),
                        DegFromRad(model.angle_rad[i]));
  }
  yaml += fmt::format("delta_radius_mm: {}\n", of_towers(model.radius_mm));
  yaml += fmt::format("arm_length_mm: {}\n", of_towers(model.arm_mm));
  yaml += fmt::format("endstop_mm: {}\n", of_towers(model.endstop_mm));
  if (Known(text.print_radius_mm)) {
    yaml +=
        fmt::format("# it prints within {:g} mm of the middle\n", text.print_radius_mm);
  }
  if (std::ranges::all_of(
          text.drive, [](const KlipperDrive& drive) { return Known(drive.step_mm); })) {
    yaml += fmt::format(
        "\nsettings:\n  steps_per_mm: {{a: {:.6g}, b: {:.6g}, c: {:.6g}}}\n",
        1 / text.drive[0].step_mm,
        1 / text.drive[1].step_mm,
        1 / text.drive[2].step_mm);
  }
  return yaml;
}

std::string MachineNameOf(const std::string& file) {
  std::string name;
  for (const char c : std::filesystem::path(file).stem().string()) {
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += is_plain ? c : '_';
  }
  constexpr std::size_t kLongest = 60;
  return name.empty() ? "delta" : name.substr(0, kLongest);
}

}  // namespace caltwin
