#include "sim/measure/import/kinds/printer_of_cfg.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr double kMost_mm = 1e4;

/// A motor as Klipper has it.
struct Motor {
  double mm_per_rev = 0, full_steps = 200, microsteps = 16;
  double steps_per_mm() const { return full_steps * microsteps / mm_per_rev; }
};

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

  Motor MotorOf(const std::string& section) {
    return {
        .mm_per_rev = Required(section, "rotation_distance", 1e-3) /
                      GearRatioOf(cfg_, section, &faults_),
        .full_steps = Number(section, "full_steps_per_rotation", 1, 1e4).value_or(200),
        .microsteps = Required(section, "microsteps", 1, 256)};
  }

  struct Feeds {
    double x_mm_s, x_mm_s2, z_mm_s, z_mm_s2;
  };
  Feeds FeedsOf() {
    const double v = Required("printer", "max_velocity", 1e-3);
    const double a = Required("printer", "max_accel", 1e-3, 1e6);
    return {.x_mm_s = v,
            .x_mm_s2 = a,
            .z_mm_s = Number("printer", "max_z_velocity", 1e-3).value_or(v),
            .z_mm_s2 = Number("printer", "max_z_accel", 1e-3, 1e6).value_or(a)};
  }

  // Klipper homes towards the nearer end.
  std::string AxisLine(char axis, const Feeds& feeds, bool is_on_screws) {
    const std::string section = std::string("stepper_") + axis;
    const bool is_z = axis == 'z';
    const double max_mm = Required(section, "position_max");
    const double min_mm = Number(section, "position_min").value_or(0);
    const double end_mm = Number(section, "position_endstop").value_or(min_mm);
    const bool is_at_max = cfg_.Flag(section, "homing_positive_dir")
                               .value_or(end_mm > (min_mm + max_mm) / 2);
    const Motor motor = MotorOf(section);
    // The switch is the end of the drawn travel; a bed on screws is told from 0 up.
    const bool has_home = !(is_z && is_on_screws);
    const double low_mm = !has_home ? 0 : is_at_max ? min_mm : end_mm;
    const double high_mm = has_home && is_at_max ? end_mm : max_mm;
    return fmt::format(
        "  {}: {{min_mm: {:g}, max_mm: {:g}, {}{}: {:g}, full_steps_per_rev: {:g}, "
        "microsteps: {:g},\n      max_feed_mm_s: {:g}, acceleration_mm_s2: {:g}}}\n",
        axis,
        low_mm,
        high_mm,
        has_home ? is_at_max ? "home: max, " : "home: min, " : "",
        is_z ? "lead_mm" : "pulley_mm_per_rev",
        motor.mm_per_rev,
        motor.full_steps,
        motor.microsteps,
        is_z ? feeds.z_mm_s : feeds.x_mm_s,
        is_z ? feeds.z_mm_s2 : feeds.x_mm_s2);
  }

  std::vector<std::vector<double>> Places(const std::string& section, const char* key) {
    std::vector<std::vector<double>> places;
    const CfgSetting* const setting = cfg_.Find(section, key);
    if (setting == nullptr) return places;
    std::vector<CsvField> lines = setting->more;
    if (!setting->value.text.empty()) lines.insert(lines.begin(), setting->value);
    for (const CsvField& line : lines) {
      const auto numbers = NumbersIn(line, key, cfg_.name(), &faults_);
      if (numbers.size() == 2) places.push_back(numbers);
    }
    return places;
  }

  int NumZ() const {
    int num = 1;
    while (cfg_.Find(fmt::format("stepper_z{}", num), "step_pin") != nullptr) ++num;
    return num;
  }

  // Empty: it has none.
  std::string Screws() {
    auto places = Places("z_tilt", "z_positions");
    if (places.empty()) places = Places("z_tilt_ng", "z_positions");
    if (NumZ() != 3 || places.size() != 3) return "";
    std::string text = "\nscrews:\n";
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Motor motor = MotorOf(i == 0 ? "stepper_z" : fmt::format("stepper_z{}", i));
      text += fmt::format(
          "  z{}: {{at_mm: [{:g}, {:g}], lead_mm: {:g}, full_steps_per_rev: {:g}, "
          "microsteps: {:g}}}\n",
          i + 1,
          places[i][0],
          places[i][1],
          motor.mm_per_rev,
          motor.full_steps,
          motor.microsteps);
    }
    return text;
  }

  std::string Corners() {
    const auto places = Places("quad_gantry_level", "gantry_corners");
    if (NumZ() != 4 || places.size() != 2) return "";
    return fmt::format("\ngantry: {{corners_mm: [[{:g}, {:g}], [{:g}, {:g}]]}}\n",
                       places[0][0],
                       places[0][1],
                       places[1][0],
                       places[1][1]);
  }

  std::string Head(std::string_view kinematics) const {
    return fmt::format(
        "# As {} has it: what its firmware believes, not what was built.\n"
        "format: 1\nname: {}\nkinematics: {}\n",
        cfg_.name(),
        name_,
        kinematics);
  }

  std::string OnAxes(bool is_corexy) {
    const std::string screws = Screws();
    const std::string corners = is_corexy ? Corners() : "";
    const bool is_on_screws = !screws.empty();
    const Feeds feeds = FeedsOf();
    std::string text = Head(is_corexy      ? "corexy"
                            : is_on_screws ? "triple_z"
                                           : "cartesian") +
                       screws + corners + "\naxes:\n";
    for (const char axis : {'x', 'y', 'z'}) {
      text += AxisLine(axis, feeds, is_on_screws);
    }
    if (!faults_.empty()) return "";
    const double z = MotorOf("stepper_z").steps_per_mm();
    if (is_on_screws && !is_corexy) {
      return text + fmt::format("\nsettings: {{steps_per_mm: {{z: {:g}}}}}\n", z);
    }
    return text + fmt::format(
                      "\nsettings: {{steps_per_mm: {{{}: {:g}, {}: {:g}, z: "
                      "{:g}}}}}\n",
                      is_corexy ? 'a' : 'x',
                      MotorOf("stepper_x").steps_per_mm(),
                      is_corexy ? 'b' : 'y',
                      MotorOf("stepper_y").steps_per_mm(),
                      z);
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
