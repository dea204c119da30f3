#include "sim/measure/import/kinds/printer_of_cfg.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/machine_text.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr double kMost_mm = 1e4;

class Reader {
 public:
  Reader(const PrinterCfg& cfg, std::string name) : cfg_(cfg), name_(std::move(name)) {}

  std::string Text() {
    const std::string kinematics = WordOf("printer", "kinematics");
    std::string text;
    if (kinematics == "delta") {
      text = Delta();
    } else if (kinematics == "cartesian" || kinematics == "corexy") {
      text = OnAxes(kinematics == "corexy");
    } else {
      const CfgSetting* const given = cfg_.Find("printer", "kinematics");
      faults_.Add(given != nullptr ? PlaceOf(given->value, cfg_.name())
                                   : Place{.file = cfg_.name()},
                  fmt::format("[printer] kinematics '{}' is no machine of caltwin's",
                              kinematics),
                  "delta, cartesian or corexy");
    }
    faults_.ThrowIfAny();
    return text;
  }

 private:
  std::string WordOf(const char* section, const char* key) const {
    const CfgSetting* const setting = cfg_.Find(section, key);
    return setting == nullptr ? "" : setting->value.text;
  }

  std::optional<double> Number(const std::string& section,
                               const char* key,
                               double min = -kMost_mm,
                               double max = kMost_mm) {
    return cfg_.Number(section, key, min, max, &faults_);
  }

  double Required(const std::string& section,
                  const char* key,
                  double min = -kMost_mm,
                  double max = kMost_mm) {
    const std::size_t before = faults_.size();
    const auto number = Number(section, key, min, max);
    if (number) return *number;
    if (faults_.size() == before) {
      faults_.Add(cfg_.PlaceOfSection(section),
                  fmt::format("[{}] has no {}", section, key),
                  "a Klipper configuration says it of every axis");
    }
    return 1;
  }

  // What drives it, and how fast: `is_z` by its own limits.
  AxisSettingsText DriveOf(const std::string& section, bool is_z) {
    const double v_mm_s = Required("printer", "max_velocity", 1e-3);
    const double a_mm_s2 = Required("printer", "max_accel", 1e-3, 1e6);
    AxisSettingsText axis{
        .full_steps_per_rev =
            Number(section, "full_steps_per_rotation", 1, 1e4).value_or(200),
        .microsteps = Required(section, "microsteps", 1, 256),
        .max_feed_mm_s = v_mm_s,
        .acceleration_mm_s2 = a_mm_s2};
    axis.steps_per_mm = axis.full_steps_per_rev * axis.microsteps *
                        GearRatioOf(cfg_, section, &faults_) /
                        Required(section, "rotation_distance", 1e-3);
    if (is_z) {
      axis.max_feed_mm_s = Number("printer", "max_z_velocity", 1e-3).value_or(v_mm_s);
      axis.acceleration_mm_s2 =
          Number("printer", "max_z_accel", 1e-3, 1e6).value_or(a_mm_s2);
    }
    return axis;
  }

  // Klipper homes towards the nearer end. The switch is the end of the drawn travel; a
  // bed on screws is told from 0 up.
  AxisSettingsText AxisOf(char letter, bool is_on_screws) {
    const std::string section = std::string("stepper_") + letter;
    const bool is_z = letter == 'z';
    const double max_mm = Required(section, "position_max");
    const double min_mm = Number(section, "position_min").value_or(0);
    const double end_mm = Number(section, "position_endstop").value_or(min_mm);
    const bool is_at_max = cfg_.Flag(section, "homing_positive_dir")
                               .value_or(end_mm > (min_mm + max_mm) / 2);
    AxisSettingsText axis = DriveOf(section, is_z);
    axis.max_mm = max_mm;
    if (is_z && is_on_screws) return axis;
    axis.min_mm = is_at_max ? min_mm : end_mm;
    axis.max_mm = is_at_max ? end_mm : max_mm;
    axis.home = is_at_max ? HomeEnd::kMax : HomeEnd::kMin;
    return axis;
  }

  std::vector<std::array<double, 2>> Places(const std::string& section,
                                            const char* key) {
    std::vector<std::array<double, 2>> places;
    const CfgSetting* const setting = cfg_.Find(section, key);
    if (setting == nullptr) return places;
    std::vector<CsvField> lines = setting->more;
    if (!setting->value.text.empty()) lines.insert(lines.begin(), setting->value);
    for (const CsvField& line : lines) {
      const auto numbers = NumbersIn(line, key, cfg_.name(), &faults_);
      if (numbers.size() == 2) places.push_back({numbers[0], numbers[1]});
    }
    return places;
  }

  int NumZ() const {
    int num = 1;
    while (cfg_.Find(fmt::format("stepper_z{}", num), "step_pin") != nullptr) ++num;
    return num;
  }

  std::string OnAxes(bool is_corexy) {
    CartesianMachineText machine{
        .source = cfg_.name(), .name = name_, .is_corexy = is_corexy};
    auto screws_mm = Places("z_tilt", "z_positions");
    if (screws_mm.empty()) screws_mm = Places("z_tilt_ng", "z_positions");
    if (NumZ() == 3 && screws_mm.size() == 3) machine.screws_mm = screws_mm;
    const auto corners_mm = Places("quad_gantry_level", "gantry_corners");
    if (is_corexy && NumZ() == 4 && corners_mm.size() == 2) {
      machine.corners_mm = corners_mm;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      machine.axes[i] = AxisOf("xyz"[i], !machine.screws_mm.empty());
    }
    return CartesianMachineYaml(machine);
  }

  std::string Delta() {
    const auto geometry = ReadKlipperGeometry(cfg_, std::nullopt, &faults_);
    if (!geometry) return "";
    std::string text = DeltaMachineYaml({.source = cfg_.name(),
                                         .name = name_,
                                         .model = geometry->model,
                                         .drive = geometry->drive,
                                         .print_radius_mm = geometry->print_radius_mm});
    if (Known(geometry->print_radius_mm)) {
      text += fmt::format("print_radius_mm: {:g}\n", geometry->print_radius_mm);
    }
    return text;
  }

  const PrinterCfg& cfg_;
  std::string name_;
  Faults faults_{};
};

}  // namespace

std::string MachineFileOf(const PrinterCfg& cfg, const std::string& name) {
  return Reader(cfg, name).Text();
}

}  // namespace caltwin
