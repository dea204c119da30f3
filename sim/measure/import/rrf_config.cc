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
#include "sim/machine/machine_text.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr std::array kNominal_deg = {210.0, 330.0, 90.0};
constexpr double kLongest_mm = 10'000;
constexpr double kWidest_deg = 60;

constexpr const char* kLeast = "M208 S1";

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
  constexpr std::array<std::string_view, 9> kWanted = {
      "M665", "M666", "M92", "M350", "M208", "M425", "M667", "M669", "M671"};
  std::map<std::string, Words> commands;
  for (const TextLine& line : LinesOf(text)) {
    const CsvRecord words = WordsOf(line);
    if (words.empty()) continue;
    std::string command = words.front().text;
    if (std::ranges::find(kWanted, command) == kWanted.end()) continue;
    // The least and the most of an axis stand in lines of their own.
    const bool is_least =
        command == "M208" &&
        std::ranges::any_of(words, [](auto& word) { return word.text == "S1"; });
    if (is_least) command = kLeast;
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
    if (!commands_.contains("M665")) return ReadStraight(options);
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
    for (std::size_t i = 0; i < 3; ++i) {
      const char letter = "XYZ"[i];
      drive_[i].microsteps = Number("M350", letter, kUnknown, 1024);
      if (step_mm) {
        drive_[i].step_mm = *step_mm;
        continue;
      }
      const double steps_per_mm =
          Number("M92", letter, kUnknown, SettingsInForce::kSteps_per_mm.max);
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

  // Three straight axes: M92, M208, M671.
  Imported ReadStraight(const ImportOptions& options) {
    CartesianMachineText machine{
        .source = std::filesystem::path(name_).filename().string(),
        .name = MachineNameOf(name_),
        .is_corexy =
            Number("M669", 'K', 0, 100) == 1 || Number("M667", 'S', 0, 100) == 1};
    RequireSteps(options);
    for (std::size_t i = 0; i < 3; ++i) ReadAxis(i, options, &machine.axes[i]);
    ReadScrews(&machine);
    faults_.ThrowIfAny();
    Imported imported;
    imported.machine_yaml = CartesianMachineYaml(machine);
    imported.recognised = {
        fmt::format("a RepRapFirmware machine of straight axes{}{}",
                    machine.is_corexy ? ", CoreXY" : "",
                    machine.screws_mm.empty() ? "" : ", its bed on three screws")};
    imported.assumed = {"motors of 200 full steps in a turn"};
    const int num_screws = NumScrews();
    if (num_screws > 0 && machine.screws_mm.empty()) {
      imported.warnings.push_back(fmt::format(
          "M671 has {} screws: a machine file has three or none, and this one none",
          num_screws));
    }
    return imported;
  }

  void RequireSteps(const ImportOptions& options) {
    const bool are_there =
        options.step_mm || std::ranges::all_of(std::string("XYZ"), [&](char letter) {
          return Word("M92", letter) != nullptr;
        });
    if (are_there) return;
    throw InputError({.file = name_, .line = 1, .column = 1},
                     "commands, and no reading and no machine among them: neither a "
                     "delta's geometry nor the steps/mm of X, Y and Z",
                     "M665 L R H (and M666 X Y Z), or M92 X Y Z (and M208, M671) of a "
                     "RepRapFirmware config.g or config-override.g");
  }

  void ReadAxis(std::size_t i, const ImportOptions& options, AxisSettingsText* axis) {
    const char letter = "XYZ"[i];
    constexpr double kMost = SettingsInForce::kSteps_per_mm.max;
    axis->steps_per_mm =
        options.step_mm ? 1 / *options.step_mm : Number("M92", letter, kUnknown, kMost);
    if (!SettingsInForce::kSteps_per_mm.Contains(axis->steps_per_mm)) {
      faults_.Add(Word("M92", letter) == nullptr ? Place{.file = name_}
                                                 : PlaceOf(*Word("M92", letter), name_),
                  fmt::format("M92 {}{:g}: steps/mm are from {:g} to {:g}",
                              letter,
                              axis->steps_per_mm,
                              SettingsInForce::kSteps_per_mm.min,
                              kMost));
    }
    axis->microsteps = Number("M350", letter, kUnknown, 1024);
    axis->backlash_mm =
        Number("M425", letter, kUnknown, SettingsInForce::kBacklash_mm.max);
    // "M208 X-5:300", or M208 X300 after M208 X-5 S1.
    const auto both = Numbers("M208", letter);
    if (both.size() == 2) {
      axis->min_mm = both[0];
      axis->max_mm = both[1];
    } else {
      axis->min_mm = Number(kLeast, letter, 0, kLongest_mm);
      axis->max_mm = Number("M208", letter, kUnknown, kLongest_mm);
    }
  }

  int NumScrews() const {
    const CsvField* word = Word("M671", 'X');
    return word == nullptr ? 0
                           : static_cast<int>(std::ranges::count(word->text, ':')) + 1;
  }

  void ReadScrews(CartesianMachineText* machine) {
    const auto x_mm = Numbers("M671", 'X'), y_mm = Numbers("M671", 'Y');
    if (x_mm.size() != y_mm.size()) {
      faults_.Add(PlaceOf(*Word("M671", x_mm.empty() ? 'Y' : 'X'), name_),
                  fmt::format("M671 has {} X and {} Y", x_mm.size(), y_mm.size()),
                  "one of each for every screw, apart by colons");
      return;
    }
    constexpr std::size_t kScrews = 3;
    if (x_mm.size() != kScrews) return;
    for (std::size_t i = 0; i < kScrews; ++i)
      machine->screws_mm.push_back({x_mm[i], y_mm[i]});
  }

  // Numbers apart by colons; none where the word is not there.
  std::vector<double> Numbers(const char* command, char letter) {
    std::vector<double> numbers;
    const CsvField* word = Word(command, letter);
    if (word == nullptr) return numbers;
    CsvField part = *word;
    std::size_t at = 0;
    while (at <= word->text.size()) {
      const std::size_t end = std::min(word->text.find(':', at), word->text.size());
      part.text = word->text.substr(at, end - at);
      part.column = word->column + static_cast<int>(at);
      const double number =
          NumberIn(part, fmt::format("{} {}", command, letter), name_, &faults_);
      if (std::abs(number) > kLongest_mm) {
        faults_.Add(
            PlaceOf(part, name_),
            fmt::format(
                "{} {}{:g} is beyond {:g}", command, letter, number, kLongest_mm));
      }
      numbers.push_back(number);
      at = end + 1;
    }
    return numbers;
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
