#include "sim/measure/import/printer_cfg_adapted.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <boost/algorithm/string/case_conv.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/printer_cfg.h"
#include "sim/measure/import/printer_cfg_parts.h"
#include "sim/measure/import/printer_cfg_text.h"

namespace caltwin {
namespace {

constexpr std::string_view kBlanks = " \t", kMacro = "gcode_macro ";

std::string_view Stripped(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Of "[stepper_x]" stepper_x; empty: it is no heading.
std::string_view TitleOf(std::string_view line) {
  if (!line.starts_with('[') || line.find(']') == line.npos) return {};
  return Stripped(line.substr(1, line.find(']') - 1));
}

std::string_view FirstWord(std::string_view title) {
  return title.substr(0, title.find_first_of(kBlanks));
}

// Of "step_pin: PF0" step_pin; empty: the line goes on with what was before.
std::string_view KeyOf(std::string_view line) {
  if (line.empty() || kBlanks.find(line.front()) != kBlanks.npos) return {};
  if (line.front() == '#' || line.front() == ';') return {};
  return Stripped(line.substr(0, line.find_first_of(":=")));
}

bool IsAtTop(const PrinterCfg& cfg) {
  const auto is_positive = cfg.Flag("stepper_z", "homing_positive_dir");
  if (is_positive) return *is_positive;
  Faults ignored;
  const auto number = [&](const char* key) {
    return cfg.Number("stepper_z", key, -1e4, 1e4, &ignored);
  };
  const double min_mm = number("position_min").value_or(0);
  const double max_mm = number("position_max").value_or(0);
  return number("position_endstop").value_or(min_mm) > (min_mm + max_mm) / 2;
}

class Adapter {
 public:
  Adapter(const std::string& config, const std::string& drawn)
      : config_(config), given_(config, "printer.cfg"), drawn_(drawn, "drawn") {
    const CfgSetting* const z = given_.Find("stepper_z", "endstop_pin");
    const bool has_own = z != nullptr && z->value.text.starts_with("probe:");
    is_z_by_probe_ = has_own || (z != nullptr && IsAtTop(given_) != IsAtTop(drawn_));
    if (is_z_by_probe_ && !has_own) {
      changes_.emplace_back(
          "[stepper_z]: homes by the probe; the twin has the switch of Z at the other "
          "end of its travel");
    }
    for (const std::string_view line : RawLines(config)) {
      const std::string_view title = TitleOf(line);
      if (title.starts_with(kMacro)) {
        macros_.insert(boost::to_upper_copy(std::string(title.substr(kMacro.size()))));
      }
      for (const SaidTo& said : SaidToMissing()) {
        if (title.starts_with(said.part) && !IsKept(title)) {
          unheard_.insert(said.commands.begin(), said.commands.end());
        }
      }
      for (const SaidTo& said : SaidToHeaters()) {
        if (title == said.part) {
          muted_.insert(said.commands.begin(), said.commands.end());
        }
      }
    }
  }

  AdaptedConfig Done() {
    for (const std::string_view line : RawLines(config_)) Take(line);
    if (!left_out_.empty()) {
      changes_.push_back(fmt::format("left out, the twin has no such parts: {}",
                                     fmt::join(left_out_, ", ")));
    }
    std::string deaf;
    std::vector<std::string> names;
    const auto add = [&](const std::string& command, const std::string& renamed) {
      if (macros_.contains(command)) return;
      names.push_back(command);
      deaf += fmt::format("[gcode_macro {}]\n{}gcode: G4 P0\n", command, renamed);
    };
    for (const std::string& command : muted_) {
      add(command, "rename_existing: " + RealNameOf(command) + "\n");
    }
    unheard_.insert(renamed_.begin(), renamed_.end());
    for (const std::string& command : unheard_) {
      if (!muted_.contains(command)) add(command, "");
    }
    if (!deaf.empty()) {
      changes_.push_back(fmt::format("does nothing, for want of the part: {}",
                                     fmt::join(names, ", ")));
      deaf = "# What macros say to parts that the twin does not have.\n" + deaf;
    }
    if (has_display_ && given_.Sections("display_status").empty()) {
      deaf += "[display_status]\n";  // What a display would load: M117, M73.
    }
    return {.text = WithAdded(text_, deaf), .changes = std::move(changes_)};
  }

 private:
  enum class Now { kKeep, kDrop, kMotor, kProbe };

  void Take(std::string_view line) {
    constexpr std::string_view kSaved = "#*#";
    is_saved_ = line.starts_with(kSaved);
    const std::string_view body =
        is_saved_ ? line.substr(std::min(line.size(), kSaved.size() + 1)) : line;
    const std::string_view title = TitleOf(body);
    if (!title.empty()) {
      Begin(title, line);
      return;
    }
    if (is_saved_ && body.starts_with('<')) {
      now_ = Now::kKeep;  // The heading of what was saved.
    }
    const std::string key = Lowered(KeyOf(body));
    if (!key.empty()) is_key_kept_ = Keeps(key, body);
    if (now_ == Now::kDrop || !is_key_kept_) return;
    const bool is_bound = key == "mesh_min" || key == "mesh_max";
    Add(is_bound && title_ == "bed_mesh" && !is_saved_ ? Reached(key, line)
                                                       : std::string(line));
  }

  void Begin(std::string_view title, std::string_view line) {
    title_ = title;
    is_key_kept_ = true;
    const std::string_view word = FirstWord(title);
    if (title == "mcu") {
      now_ = Now::kDrop;
      if (is_saved_) return;
      Add(line);
      Add("serial: " + drawn_.Find("mcu", "serial")->value.text + "\n");
    } else if (IsAmong(kProbes, word)) {
      BeginProbe(word);
    } else if (title.starts_with("stepper_")) {
      BeginMotor(line);
    } else if (title == "extruder" || title == "heater_bed") {
      BeginHeater(title);
    } else if (IsKept(title)) {
      now_ = Now::kKeep;
      Add(line);
      if (title == "printer") AddLower("printer", "minimum_z_position");
    } else {
      LeaveOut();
    }
  }

  bool IsKept(std::string_view title) const {
    return IsAmong(kKeptSections, FirstWord(title)) && HasMotorsFor(FirstWord(title));
  }

  // What levels by several motors of Z the twin has, or has not.
  bool HasMotorsFor(std::string_view word) const {
    const bool is_tilt = word == "z_tilt" || word == "z_tilt_ng";
    if (is_tilt) return drawn_.Find("z_tilt", "z_positions") != nullptr;
    return word != "quad_gantry_level" ||
           drawn_.Find("quad_gantry_level", "gantry_corners") != nullptr;
  }

  // A probe may have to look below where the person's own triggers.
  void AddLower(const char* section, const char* key) {
    Faults ignored;
    const auto drawn = drawn_.Number(section, key, -1e4, 1e4, &ignored);
    const auto given = given_.Number(section, key, -1e4, 1e4, &ignored);
    is_lower_ = drawn && given.value_or(0) > *drawn;
    if (!is_lower_ || is_saved_) return;
    Add(fmt::format("{}: {:g}", key, *drawn));
    changes_.push_back(fmt::format(
        "[{}]: {} {:g}, that the probe may look lower", section, key, *drawn));
  }

  // A mesh is measured where the nozzle comes, not where a probe beside it would.
  std::string Reached(std::string_view key, std::string_view line) {
    Faults ignored;
    auto at_mm = given_.Numbers("bed_mesh", key, 2, &ignored);
    if (!at_mm) return std::string(line);
    const auto asked_mm = *at_mm;
    for (std::size_t i = 0; i < 2; ++i) {
      const char* const stepper = i == 0 ? "stepper_x" : "stepper_y";
      const auto limit = [&](const char* name, double otherwise) {
        return given_.Number(stepper, name, -1e4, 1e4, &ignored).value_or(otherwise);
      };
      const double most_mm = limit("position_max", (*at_mm)[i]);
      (*at_mm)[i] = std::max(limit("position_min", 0), std::min((*at_mm)[i], most_mm));
    }
    if (*at_mm == asked_mm) return std::string(line);
    const std::string reached =
        fmt::format("{}: {:g}, {:g}", key, (*at_mm)[0], (*at_mm)[1]);
    changes_.push_back("[bed_mesh]: " + reached + ", as far as the nozzle comes");
    return reached;
  }

  void LeaveOut() {
    now_ = Now::kDrop;
    has_display_ |= title_ == "display";
    if (!is_saved_) left_out_.insert("[" + title_ + "]");
  }

  // Once, of however many parts it is written in.
  void BeginHeater(std::string_view title) {
    now_ = Now::kDrop;
    if (is_saved_ || !heaters_.insert(std::string(title)).second) return;
    Add("[" + title_ + "]");
    Add(std::string(title == "extruder" ? kExtruder : kBed) + std::string(kHeater));
    changes_.push_back("[" + title_ + "]: is there, and never heats");
  }

  void BeginProbe(std::string_view word) {
    const CfgSetting* const z_offset = drawn_.Find("probe", "z_offset");
    now_ = is_saved_ || z_offset == nullptr ? Now::kDrop : Now::kProbe;
    if (now_ == Now::kDrop) return;
    Add("[probe]");
    // A section may stand in parts.
    if (std::exchange(has_probe_, true)) return;
    Add("pin: PROBE");
    Add("z_offset: " + z_offset->value.text);
    changes_.push_back(fmt::format(
        "[{}]: the twin's probe is where the nozzle is, z_offset {}; no x_offset and "
        "y_offset, nothing that it does when it is taken or put down",
        word,
        z_offset->value.text));
  }

  void BeginMotor(std::string_view line) {
    if (drawn_.Find(title_, "step_pin") == nullptr) {
      LeaveOut();
      return;
    }
    now_ = Now::kMotor;
    Add(line);
    is_lower_ = false;
    if (is_saved_) return;
    if (title_ == "stepper_z") AddLower("stepper_z", "position_min");
    for (const std::string_view pin : kPins) {
      const CfgSetting* const setting = drawn_.Find(title_, pin);
      const bool is_z = title_ == "stepper_z" && pin == "endstop_pin";
      if (is_z && is_z_by_probe_) {
        Add("endstop_pin: probe:z_virtual_endstop");
      } else if (setting != nullptr && (pin != "endstop_pin" || HasEndstop())) {
        Add(fmt::format("{}: {}", pin, setting->value.text));
      }
    }
  }

  // Where a command goes that a macro stands for: numbers stay numbers, words words.
  static std::string RealNameOf(const std::string& command) {
    const bool is_numbered =
        command.size() > 1 && std::isdigit(static_cast<unsigned char>(command[1])) != 0;
    return is_numbered ? command + "0000" : "CALTWIN_" + command;
  }

  bool HasEndstop() const { return given_.Find(title_, "endstop_pin") != nullptr; }

  bool Keeps(std::string_view key, std::string_view line) {
    const std::string macro = title_.starts_with(kMacro)
                                  ? boost::to_upper_copy(title_.substr(kMacro.size()))
                                  : std::string();
    const bool is_muted = muted_.contains(macro);
    // A macro in place of a command that is not there, or is not to act: what it calls
    // by the new name does nothing either.
    if (key == "rename_existing" && (is_muted || unheard_.contains(macro))) {
      const std::size_t mark = line.find_first_of(":=");
      renamed_.push_back(
          boost::to_upper_copy(std::string(Stripped(line.substr(mark + 1)))));
      if (is_muted) Add("rename_existing: " + RealNameOf(renamed_.back()));
      return false;
    }
    if (now_ == Now::kProbe) return IsAmong(kOfAnyProbe, key);
    const bool is_lowered =
        is_lower_ && ((title_ == "printer" && key == "minimum_z_position") ||
                      (title_ == "stepper_z" && key == "position_min"));
    if (is_lowered) return false;
    if (now_ != Now::kMotor) return true;
    const bool is_end =
        title_ == "stepper_z" && is_z_by_probe_ && IsAmong(kWhichEnd, key);
    return !IsAmong(kPins, key) && !is_end;
  }

  void Add(std::string_view line) { text_.append(line).append("\n"); }

  const std::string& config_;
  PrinterCfg given_, drawn_;
  bool is_z_by_probe_ = false;
  std::string text_{};
  std::vector<std::string> changes_{};
  std::set<std::string> left_out_{}, macros_{}, heaters_{};
  std::set<std::string> unheard_{};  ///< Commands of what is left out.
  std::set<std::string> muted_{};    ///< Commands that are there and are not to act.
  std::vector<std::string> renamed_{};
  Now now_ = Now::kKeep;
  std::string title_{};
  bool is_saved_ = false, is_key_kept_ = true, has_probe_ = false, is_lower_ = false,
       has_display_ = false;
};

}  // namespace

AdaptedConfig AdaptedToTwin(const std::string& config, const std::string& drawn) {
  return Adapter(config, drawn).Done();
}

}  // namespace caltwin
