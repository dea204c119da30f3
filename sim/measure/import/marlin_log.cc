#include "sim/measure/import/marlin_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/climb.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

constexpr std::array kNominal_deg = {210.0, 330.0, 90.0};
constexpr double kLongest_mm = 10'000;

/// A line without what the host wrote before it.
struct Said {
  std::string_view text{};
  double t_s = kUnknown;
};

Said WithoutPrefix(std::string_view line) {
  constexpr std::array<std::string_view, 8> kPrefixes = {
      "Recv:", "Send:", "SENDING:", ">>>", "<<<", "echo:", ">", "<"};
  Said said{.text = line};
  // "2021-06-13 20:05:00,123 - Recv: ok": the host's clock.
  const std::size_t dash = line.find(" - ");
  if (dash != std::string_view::npos) {
    const std::string_view clock = line.substr(0, std::min(dash, line.find(',')));
    if (const auto t_s = ClockTime_s(clock)) {
      said = {line.substr(dash + 3), *t_s};
    }
  }
  for (bool is_done = false; !is_done;) {
    is_done = true;
    said.text.remove_prefix(
        std::min(said.text.size(), said.text.find_first_not_of(" \t")));
    for (const std::string_view prefix : kPrefixes) {
      if (!said.text.starts_with(prefix)) continue;
      said.text.remove_prefix(prefix.size());
      is_done = false;
    }
  }
  // "N12 G29*33": a line number.
  if (said.text.starts_with('N') && said.text.size() > 1 && said.text[1] >= '0' &&
      said.text[1] <= '9') {
    const std::size_t blank = said.text.find(' ');
    if (blank != std::string_view::npos) said.text.remove_prefix(blank + 1);
  }
  return said;
}

bool IsCommand(std::string_view text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  return text.size() == word.size() || text[word.size()] == ' ' ||
         text[word.size()] == '*';
}

class LogReader {
 public:
  LogReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    for (const TextLine& line : lines_) ReadLine(line);
    CheckClimb();
    faults_.ThrowIfAny();
    ReadGeometry();
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty() && imported_.machine_yaml.empty()) RefuseEmpty();
    for (Row& row : imported_.table.rows) {
      if (!options.campaign.empty()) row.campaign = options.campaign + row.campaign;
      if (!settings_.steps_per_mm.empty()) row.settings = kSettings;
    }
    if (!settings_.steps_per_mm.empty() && !imported_.table.rows.empty()) {
      imported_.header.settings[kSettings] = settings_;
    }
    Explain();
    return std::move(imported_);
  }

 private:
  static constexpr const char* kSettings = "m503";

  void ReadLine(const TextLine& line) {
    const Said said = WithoutPrefix(line.text);
    const std::string_view text = said.text;
    if (IsCommand(text, "G28")) {
      ++homings_;
      to_x_mm_ = to_y_mm_ = kUnknown;
    } else if (IsCommand(text, "G91")) {
      is_relative_ = true;
    } else if (IsCommand(text, "G90")) {
      is_relative_ = false;
    } else if (IsCommand(text, "G0") || IsCommand(text, "G1")) {
      ReadMove(text);
    } else if (IsCommand(text, "G29")) {
      Begin("g29");
    } else if (IsCommand(text, "G30")) {
      if (kind_ != "g30") Begin("g30");
    } else if (IsCommand(text, "M48")) {
      Begin("m48");
      x_mm_ = NumberAfter(text, " X").value_or(to_x_mm_);
      y_mm_ = NumberAfter(text, " Y").value_or(to_y_mm_);
    } else if (text.starts_with("Bed X:")) {
      ReadBed(line, said);
    } else if (IsRepeat(text)) {
      ReadRepeat(line, said);
    } else if (text.find("Leveling Grid") != std::string_view::npos) {
      if (grid_line_ == 0) grid_line_ = line.line;
    } else {
      ReadSetting(line, text);
    }
  }

  // An M48 without X and Y touches where the last move went.
  void ReadMove(std::string_view text) {
    for (const auto& [word, to_mm] :
         {std::pair{" X", &to_x_mm_}, std::pair{" Y", &to_y_mm_}}) {
      const auto value_mm = NumberAfter(text, word);
      if (value_mm) *to_mm = is_relative_ ? *to_mm + *value_mm : *value_mm;
    }
  }

  // "2 of 10: z: 0.031"
  static bool IsRepeat(std::string_view text) {
    const std::size_t of = text.find(" of ");
    return of != std::string_view::npos && NumberOf(text.substr(0, of)) &&
           text.find("z:", of) != std::string_view::npos;
  }

  void ReadBed(const TextLine& line, const Said& said) {
    const auto x_mm = NumberAfter(said.text, "X:");
    const auto y_mm = NumberAfter(said.text, "Y:");
    const auto z_mm = NumberAfter(said.text, "Z:");
    if (!x_mm || !y_mm || !z_mm) {
      faults_.Add(Here(line),
                  "this line begins like a touch, but its numbers are not all there",
                  "'Bed X: 10.00 Y: 20.00 Z: 0.03'");
      return;
    }
    if (kind_.empty() || kind_ == "m48") Begin("g30");
    if (*x_mm != x_mm_ || *y_mm != y_mm_) CheckClimb();
    x_mm_ = *x_mm;
    y_mm_ = *y_mm;
    Add(line, *z_mm, said.t_s);
  }

  void ReadRepeat(const TextLine& line, const Said& said) {
    const auto z_mm = NumberAfter(said.text, "z:");
    if (!z_mm) {
      faults_.Add(Here(line),
                  "this line begins like a touch of M48, but has no height",
                  "'2 of 10: z: 0.031'");
      return;
    }
    if (kind_ != "m48") Begin("m48");
    if (!Known(x_mm_) || !Known(y_mm_)) {
      faults_.Add(Here(line),
                  "nothing before this touch of M48 says where it lies",
                  "'M48 P10 X100 Y80', or a move to X and Y before it");
      return;
    }
    Add(line, *z_mm, said.t_s);
  }

  void Begin(const std::string& kind) {
    CheckClimb();
    kind_ = kind;
    x_mm_ = y_mm_ = kUnknown;
    if (kind == "g30" && counts_.contains(kind)) return;  // All of them together.
    ++counts_[kind];
  }

  std::string Campaign() const {
    const int count = counts_.at(kind_);
    return count == 1 ? kind_ : fmt::format("{}_{}", kind_, count);
  }

  void Add(const TextLine& line, double z_mm, double t_s) {
    if (Known(t_s) && !Known(first_s_)) first_s_ = t_s;
    Row row = BedTouchRow(Campaign(), x_mm_, y_mm_, z_mm, Here(line));
    row.t_s = t_s - first_s_;
    if (homings_ > 0) row.home = std::to_string(homings_);
    if (heights_mm_.empty()) first_ = row.place;
    heights_mm_.push_back(z_mm);
    imported_.table.rows.push_back(std::move(row));
  }

  void CheckClimb() {
    const std::string climb = ClimbText(heights_mm_);
    if (!climb.empty()) faults_.Add(first_, climb, std::string(kClimbHint));
    heights_mm_.clear();
  }

  // What M503 lists; the last of a kind counts.
  void ReadSetting(const TextLine& line, std::string_view text) {
    constexpr std::array<std::string_view, 4> kWanted = {"M92", "M665", "M666", "M851"};
    for (const std::string_view command : kWanted) {
      if (!IsCommand(text, command)) continue;
      const std::string_view words = text.substr(0, text.find_first_of("*;"));
      for (std::size_t at = words.find(' '); at < words.size();
           at = words.find(' ', at + 1)) {
        if (at + 1 >= words.size() || words[at + 1] == ' ') continue;
        const std::string_view rest = words.substr(at + 2);
        const auto value = NumberOf(rest.substr(0, rest.find(' ')));
        if (!value || std::abs(*value) > MostOf(command)) {
          faults_.Add(
              Here(line),
              fmt::format("{} {} is no number that it may have",
                          command,
                          words.substr(at + 1, words.find(' ', at + 1) - at - 1)));
          return;
        }
        numbers_[std::string(command) + words[at + 1]] = *value;
      }
      places_[std::string(command)] = Here(line);
    }
    for (const char* axis : {"X", "Y", "Z"}) {
      const auto found = numbers_.find(std::string("M92") + axis);
      if (found == numbers_.end() || found->second <= 0) continue;
      settings_.steps_per_mm[PlainWord(axis)] = found->second;
    }
  }

  static double MostOf(std::string_view command) {
    constexpr double kMostSteps_per_mm = 1e6;
    return command == "M92" ? kMostSteps_per_mm : kLongest_mm;
  }

  double Number(const std::string& name, double fallback) const {
    const auto found = numbers_.find(name);
    return found == numbers_.end() ? fallback : found->second;
  }

  // M665 L R H, angles X Y Z, rods A B C; M666 X Y Z below 0 and below the highest.
  void ReadGeometry() {
    if (!places_.contains("M665")) return;
    DeltaMachineText machine{.source = std::filesystem::path(name_).filename().string(),
                             .name = MachineNameOf(name_)};
    for (const char* word : {"M665L", "M665R", "M665H"}) {
      if (numbers_.contains(word)) continue;
      faults_.Add(places_.at("M665"), fmt::format("M665 has no {}", word[4]));
    }
    if (!faults_.empty()) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string axis(1, "XYZ"[i]);
      const std::string rod(1, "ABC"[i]);
      machine.model.radius_mm[i] = Number("M665R", 0);
      machine.model.arm_mm[i] = Number("M665L", 0) + Number("M665" + rod, 0);
      machine.model.angle_rad[i] =
          RadFromDeg(kNominal_deg[i] + Number("M665" + axis, 0));
      machine.model.endstop_mm[i] = Number("M665H", 0) - Number("M666" + axis, 0);
      const double steps_per_mm = Number("M92" + axis, 0);
      if (steps_per_mm > 0) machine.drive[i].step_mm = 1 / steps_per_mm;
    }
    if (!(machine.model.radius_mm[0] > 0) ||
        !(machine.model.arm_mm[0] > machine.model.radius_mm[0])) {
      faults_.Add(places_.at("M665"),
                  fmt::format("rods of {:g} mm at a delta radius of {:g} mm",
                              machine.model.arm_mm[0],
                              machine.model.radius_mm[0]),
                  "a rod is longer than the delta radius");
      return;
    }
    imported_.machine_yaml = DeltaMachineYaml(machine);
  }

  [[noreturn]] void RefuseEmpty() const {
    if (grid_line_ > 0) {
      throw InputError({.file = name_, .line = grid_line_, .column = 1},
                       "a levelling grid does not say where its points lie",
                       "G29 V4 prints every touch as 'Bed X: 10.00 Y: 20.00 Z: 0.03'");
    }
    throw InputError(
        {.file = name_, .line = 1, .column = 1},
        "nothing of a Marlin printer stands here",
        "touches of G30, G29 V4 and M48, and the settings of M503 are read");
  }

  void Explain() {
    if (!imported_.table.rows.empty()) {
      imported_.recognised.push_back(fmt::format("a Marlin log: {} touches, {} homings",
                                                 imported_.table.rows.size(),
                                                 homings_));
      std::vector<double> values_mm;
      for (const Row& row : imported_.table.rows) values_mm.push_back(row.value_mm);
      if (const double step_mm = StepOf(values_mm); step_mm > 0) {
        imported_.recognised.push_back(
            fmt::format("heights come in steps of {:.4g} um", UmFromMm(step_mm)));
      }
      imported_.assumed = {
          "z is the height of the bed as reported, + is up; its nominal height is 0"};
      if (homings_ == 0) {
        imported_.assumed.emplace_back("no G28 stands here: one homing session");
      }
    }
    if (!imported_.machine_yaml.empty()) {
      imported_.recognised.emplace_back("a delta's M665 and M666: endstop = H - M666");
      imported_.assumed.emplace_back(
          "X, Y, Z are the towers at 210, 330 and 90 degrees");
    }
    if (grid_line_ > 0 && !imported_.table.rows.empty()) {
      imported_.warnings.push_back(fmt::format(
          "line {}: a levelling grid without positions is left out", grid_line_));
    }
  }

  Place Here(const TextLine& line) const { return PlaceOf(line.words.front(), name_); }

  std::string name_;
  std::vector<TextLine> lines_;
  Faults faults_;
  Imported imported_;
  SettingsInForce settings_;
  std::map<std::string, double> numbers_;  ///< "M92X": 80.
  std::map<std::string, Place> places_;
  std::map<std::string, int> counts_;  ///< Campaigns of each kind so far.
  std::string kind_;
  int homings_ = 0;
  int grid_line_ = 0;
  double x_mm_ = kUnknown, y_mm_ = kUnknown, first_s_ = kUnknown;
  double to_x_mm_ = kUnknown, to_y_mm_ = kUnknown;  ///< Where the last move went.
  bool is_relative_ = false;                        ///< G91.
  std::vector<double> heights_mm_;
  Place first_;
};

}  // namespace

Imported ReadMarlinLog(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options) {
  return LogReader(text, name).Read(options);
}

}  // namespace caltwin
