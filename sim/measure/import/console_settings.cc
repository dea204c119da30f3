#include "sim/measure/import/console_settings.h"

#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/machine_text.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr std::array kNominal_deg = {210.0, 330.0, 90.0};
constexpr double kLongest_mm = 10'000;
constexpr double kUsualHeight_mm = 300;  // Older Marlin does not print it; it cancels.
constexpr std::array<std::string_view, 6> kWanted = {
    "M92", "M665", "M666", "M851", "M425", "M852"};

bool IsNumberLike(std::string_view text) {
  const std::string word = PlainWord(text.substr(0, 3));
  return word == "nan" || word == "inf" ||
         (!text.empty() &&
          std::string_view("+-.0123456789").find(text[0]) != std::string_view::npos);
}

Bounds BoundsOf(std::string_view command, char letter) {
  const bool is_axis = letter >= 'X' && letter <= 'Z';
  if (command == "M92" && is_axis) return SettingsInForce::kSteps_per_mm;
  if (command == "M425" && is_axis) return SettingsInForce::kBacklash_mm;
  return {-kLongest_mm, kLongest_mm};
}

}  // namespace

bool ConsoleSettings::Take(const ConsoleLine& line,
                           const Place& place,
                           Faults* faults) {
  for (int k = 0; k < 3; ++k) {
    const auto steps_per_mm = GrblSetting(line, 100 + k);
    if (!steps_per_mm) continue;
    if (SettingsInForce::kSteps_per_mm.Contains(*steps_per_mm)) {
      numbers_[fmt::format("M92{}", "XYZ"[k])] = *steps_per_mm;
      in_force_.steps_per_mm[std::string(1, "xyz"[k])] = *steps_per_mm;
    }
    return true;
  }
  for (const std::string_view command : kWanted) {
    if (!IsCommand(line, PlainWord(command))) continue;
    const std::string_view words = line.text.substr(0, line.text.find_first_of("*;"));
    for (std::size_t at = words.find(' '); at < words.size();
         at = words.find(' ', at + 1)) {
      if (at + 1 >= words.size() || words[at + 1] == ' ') continue;
      const std::string_view rest = words.substr(at + 2);
      const auto value = NumberOf(rest.substr(0, rest.find(' ')));
      if (!value || !BoundsOf(command, words[at + 1]).Contains(*value)) {
        // What a firmware answers ("M665 Diagonals ...") is no setting.
        if (!IsNumberLike(rest)) return true;
        faults->Add(
            place,
            fmt::format("{} {} is no number that it may have",
                        command,
                        words.substr(at + 1, words.find(' ', at + 1) - at - 1)));
        return true;
      }
      numbers_[std::string(command) + words[at + 1]] = *value;
    }
    places_[std::string(command)] = place;
    for (const char* axis : {"X", "Y", "Z"}) {
      const double steps_per_mm = Number(std::string("M92") + axis, 0);
      if (steps_per_mm > 0) in_force_.steps_per_mm[PlainWord(axis)] = steps_per_mm;
      const double gap_mm = Number(std::string("M425") + axis, -1);
      if (gap_mm >= 0) in_force_.backlash_mm[PlainWord(axis)] = gap_mm;
    }
    return true;
  }
  return false;
}

double ConsoleSettings::Number(const std::string& word, double fallback) const {
  const auto found = numbers_.find(word);
  return found == numbers_.end() ? fallback : found->second;
}

std::string ConsoleSettings::MachineText(Faults* faults) const {
  if (has_geometry()) return DeltaText(faults);
  return in_force_.steps_per_mm.size() >= 3 ? CartesianText() : "";
}

// M665 L R H, angles X Y Z, rods A B C; M666 X Y Z below 0 and below the highest.
std::string ConsoleSettings::DeltaText(Faults* faults) const {
  DeltaMachineText machine{.source = std::filesystem::path(name_).filename().string(),
                           .name = MachineNameOf(name_)};
  const Place& place = places_.at("M665");
  for (const char* word : {"M665L", "M665R"}) {
    if (numbers_.contains(word)) continue;
    faults->Add(place, fmt::format("M665 has no {}", word[4]));
  }
  if (!faults->empty()) return "";
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "XYZ"[i]);
    const std::string rod(1, "ABC"[i]);
    machine.model.radius_mm[i] = Number("M665R", 0);
    machine.model.arm_mm[i] = Number("M665L", 0) + Number("M665" + rod, 0);
    machine.model.angle_rad[i] = RadFromDeg(kNominal_deg[i] + Number("M665" + axis, 0));
    machine.model.endstop_mm[i] =
        Number("M665H", kUsualHeight_mm) - Number("M666" + axis, 0);
    const double steps_per_mm = Number("M92" + axis, 0);
    if (steps_per_mm > 0) machine.drive[i].step_mm = 1 / steps_per_mm;
  }
  if (!(machine.model.radius_mm[0] > 0) ||
      !(machine.model.arm_mm[0] > machine.model.radius_mm[0])) {
    faults->Add(place,
                fmt::format("rods of {:g} mm at a delta radius of {:g} mm",
                            machine.model.arm_mm[0],
                            machine.model.radius_mm[0]),
                "a rod is longer than the delta radius");
    return "";
  }
  return DeltaMachineYaml(machine);
}

std::string ConsoleSettings::CartesianText() const {
  CartesianMachineText machine{
      .source = std::filesystem::path(name_).filename().string(),
      .name = MachineNameOf(name_)};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    machine.axes[i].steps_per_mm = in_force_.steps_per_mm.at(axis);
    const auto gap = in_force_.backlash_mm.find(axis);
    if (gap != in_force_.backlash_mm.end()) machine.axes[i].backlash_mm = gap->second;
  }
  return CartesianMachineYaml(machine);
}

}  // namespace caltwin
