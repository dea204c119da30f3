#include "sim/measure/import/rrf_config.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr std::array kNominal_deg = {210.0, 330.0, 90.0};
constexpr double kLongest_mm = 10'000;
constexpr double kWidest_deg = 60;

/// A command's words by their letter, the last of its kind in the file.
using Words = std::map<char, CsvField>;

/// The words of a line up to its comment, each with its letter in capitals.
CsvRecord WordsOf(const TextLine& line) {
  CsvRecord words;
  for (CsvField word : line.words) {
    const std::size_t comment = word.text.find(';');
    const bool is_last = comment != std::string::npos;
    if (is_last) word.text.resize(comment);
    if (!word.text.empty()) {
      word.text.front() = static_cast<char>(
          std::toupper(static_cast<unsigned char>(word.text.front())));
      words.push_back(std::move(word));
    }
    if (is_last) break;
  }
  return words;
}

std::map<std::string, Words> CommandsOf(const std::string& text) {
  constexpr std::array<std::string_view, 4> kWanted = {"M665", "M666", "M92", "M350"};
  std::map<std::string, Words> commands;
  for (const TextLine& line : LinesOf(text)) {
    const CsvRecord words = WordsOf(line);
    if (words.empty()) continue;
    const std::string& command = words.front().text;
    if (std::ranges::find(kWanted, command) == kWanted.end()) continue;
    for (std::size_t i = 1; i < words.size(); ++i) {
      commands[command][words[i].text.front()] = {.text = words[i].text.substr(1),
                                                  .line = words[i].line,
                                                  .column = words[i].column + 1};
    }
  }
  return commands;
}

class ConfigReader {
 public:
  ConfigReader(const std::string& text, std::string name)
      : name_(std::move(name)), commands_(CommandsOf(text)) {}

  Imported Read(const ImportOptions& options) {
    if (!commands_.contains("M665")) {
      throw InputError({.file = name_, .line = 1, .column = 1},
                       "no delta's geometry stands here",
                       "it is M665 L R H (and M666 X Y Z) of a RepRapFirmware "
                       "config.g or config-override.g");
    }
    ReadGeometry();
    ReadDrives(options.step_mm);
    faults_.ThrowIfAny();
    Check();
    Imported imported;
    imported.machine_yaml = DeltaMachineYaml(text_of_machine());
    Explain(&imported);
    return imported;
  }

 private:
  const CsvField* Word(const char* command, char letter) const {
    const auto found = commands_.find(command);
    if (found == commands_.end()) return nullptr;
    const auto word = found->second.find(letter);
    return word == found->second.end() ? nullptr : &word->second;
  }

  double Number(const char* command, char letter, double fallback, double most) {
    const CsvField* word = Word(command, letter);
    if (word == nullptr) return fallback;
    const double value =
        NumberIn(*word, fmt::format("{} {}", command, letter), name_, &faults_);
    if (std::abs(value) <= most) return value;
    faults_.Add(PlaceOf(*word, name_),
                fmt::format("{} {}{:g} is beyond {:g}", command, letter, value, most));
    return 0;
  }

  double Needed(const char* command, char letter, const char* what) {
    if (Word(command, letter) == nullptr) {
      faults_.Add({.file = name_, .line = 1, .column = 1},
                  fmt::format("{} has no {}: {}", command, letter, what));
      return kUnknown;
    }
    return Number(command, letter, 0, kLongest_mm);
  }

  /// L: one arm for all, or three apart by colons.
  void ReadArms() {
    const CsvField* word = Word("M665", 'L');
    if (word == nullptr) {
      Needed("M665", 'L', "the length of the arms");
      return;
    }
    std::vector<double> arms_mm;
    std::string_view rest = word->text;
    while (true) {
      const std::string_view one = rest.substr(0, rest.find(':'));
      arms_mm.push_back(NumberIn(
          {.text = std::string(one), .line = word->line, .column = word->column},
          "M665 L",
          name_,
          &faults_));
      if (one.size() == rest.size() || arms_mm.size() > 8) break;
      rest.remove_prefix(one.size() + 1);
    }
    if (arms_mm.size() != 1 && arms_mm.size() != 3) {
      faults_.Add(PlaceOf(*word, name_),
                  fmt::format("M665 L has {} arms", arms_mm.size()),
                  "one length for all towers, or three apart by colons");
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      model_.arm_mm[i] = arms_mm.size() == 3 ? arms_mm[i] : arms_mm[0];
    }
  }

  void ReadGeometry() {
    ReadArms();
    const double radius_mm = Needed("M665", 'R', "the delta radius");
    const double height_mm = Needed("M665", 'H', "the homed height");
    for (std::size_t i = 0; i < 3; ++i) {
      const char letter = "XYZ"[i];
      model_.radius_mm[i] = radius_mm;
      model_.endstop_mm[i] = height_mm + Number("M666", letter, 0, kLongest_mm);
      model_.angle_rad[i] =
          RadFromDeg(kNominal_deg[i] + Number("M665", letter, 0, kWidest_deg));
    }
    print_radius_mm_ = Number("M665", 'B', kUnknown, kLongest_mm);
    tilt_x_percent_ = Number("M666", 'A', 0, 100);
    tilt_y_percent_ = Number("M666", 'B', 0, 100);
  }

  void ReadDrives(std::optional<double> step_mm) {
    constexpr double kMostSteps_per_mm = 1e6;
    for (std::size_t i = 0; i < 3; ++i) {
      const char letter = "XYZ"[i];
      drive_[i].microsteps = Number("M350", letter, kUnknown, 1024);
      if (step_mm) {
        drive_[i].step_mm = *step_mm;
        continue;
      }
      const double steps_per_mm = Number("M92", letter, kUnknown, kMostSteps_per_mm);
      if (!Known(steps_per_mm)) continue;
      if (steps_per_mm <= 0) {
        faults_.Add(PlaceOf(*Word("M92", letter), name_),
                    fmt::format("M92 {}{:g}: not above 0", letter, steps_per_mm));
      } else {
        drive_[i].step_mm = 1 / steps_per_mm;
      }
    }
    const bool is_whole = Known(drive_[0].step_mm) && Known(drive_[1].step_mm) &&
                          Known(drive_[2].step_mm);
    if (!is_whole) drive_[0].step_mm = kUnknown;
  }

  void Check() {
    for (std::size_t i = 0; i < 3; ++i) {
      if (model_.radius_mm[i] > 0 && model_.arm_mm[i] > model_.radius_mm[i]) continue;
      throw InputError(
          PlaceOf(*Word("M665", 'R'), name_),
          fmt::format("arms of {:g} mm at a delta radius of {:g} mm",
                      model_.arm_mm[i],
                      model_.radius_mm[i]),
          "an arm is longer than the delta radius, or the nozzle does not hang in the "
          "middle");
    }
  }

  DeltaMachineText text_of_machine() const {
    return {.source = std::filesystem::path(name_).filename().string(),
            .name = MachineNameOf(name_),
            .model = model_,
            .drive = drive_,
            .print_radius_mm = print_radius_mm_};
  }

  void Explain(Imported* imported) const {
    imported->recognised = {fmt::format(
        "a RepRapFirmware delta: arms {:g} {:g} {:g}, delta radius {:g}, endstops {:g} "
        "{:g} {:g} mm",
        model_.arm_mm[0],
        model_.arm_mm[1],
        model_.arm_mm[2],
        model_.radius_mm[0],
        model_.endstop_mm[0],
        model_.endstop_mm[1],
        model_.endstop_mm[2])};
    imported->assumed = {"X, Y, Z are the towers at 210, 330 and 90 degrees"};
    if (!Known(drive_[0].step_mm)) {
      imported->warnings.emplace_back(
          "no steps per mm here (M92 stands in config.g): the machine file has none");
    }
    if (tilt_x_percent_ != 0 || tilt_y_percent_ != 0) {
      imported->warnings.push_back(
          fmt::format("M666 A{:g} B{:g}: the firmware levels a bed tilted by that many "
                      "percent along x and y; a machine file does not hold it",
                      tilt_x_percent_,
                      tilt_y_percent_));
    }
  }

  std::string name_;
  std::map<std::string, Words> commands_;
  Faults faults_;
  DeltaModel<double> model_;
  std::array<KlipperDrive, 3> drive_;
  double print_radius_mm_ = kUnknown;
  double tilt_x_percent_ = 0, tilt_y_percent_ = 0;
};

}  // namespace

Imported ReadRrfConfig(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options) {
  return ConfigReader(text, name).Read(options);
}

}  // namespace caltwin
