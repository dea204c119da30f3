#include "sim/controllers/linuxcnc/own_ini.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/machine_text.h"

namespace caltwin {
namespace linuxcnc {
namespace {

constexpr double kTable_mm = 5, kOutOfTheWay_mm = 3;

std::optional<double> Number(const std::string& ini,
                             const std::string& section,
                             std::string_view key) {
  const std::string text = IniValue(ini, section, key);
  double number = 0;
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  return number;
}

/// What an INI file says of X, Y and Z, in its own units.
class Reader {
 public:
  Reader(const std::string& ini, std::string file) : ini_(ini), file_(std::move(file)) {
    if (IniIncludes(ini)) {
      throw InputError({.file = file_},
                       "it takes in other files",
                       "put what they have in the place of each #INCLUDE");
    }
    const std::string kinematics = IniValue(ini, "KINS", "KINEMATICS");
    if (!kinematics.starts_with("trivkins")) {
      throw InputError({.file = file_},
                       fmt::format("[KINS] KINEMATICS '{}' is no machine that can be "
                                   "made of an INI file",
                                   kinematics),
                       "trivkins: every joint moves an axis of its own");
    }
    const std::string units = IniValue(ini, "TRAJ", "LINEAR_UNITS");
    is_inch_ = units == "inch" || units == "in" || units == "imperial";
    letters_ = LettersOf(kinematics);
    const auto others = letters_.find_first_not_of("XYZ");
    const std::string mine = letters_.substr(0, others);
    const auto num = [&](char letter) {
      return std::ranges::count(mine, letter);
    };
    if (num('X') != 1 || num('Y') < 1 || num('Y') > 2 || num('Z') != 1) {
      throw InputError(
          {.file = file_},
          fmt::format("its joints are those of '{}'", letters_),
          "X, Y and Z first, each once, or two of Y: a beam with a motor at "
          "each end");
    }
    num_joints_ = mine.size();
  }

  double mm_per_unit() const { return is_inch_ ? 25.4 : 1; }
  std::size_t num_joints() const { return num_joints_; }
  const std::string& letters() const { return letters_; }
  bool has_beam() const { return num_joints_ == 4; }

  static std::string Joint(std::size_t joint) { return fmt::format("JOINT_{}", joint); }
  static std::string Axis(char letter) { return fmt::format("AXIS_{}", letter); }

  std::size_t FirstJointOf(char letter) const { return letters_.find(letter); }
  /// Of the axis, or else of its joint.
  std::optional<double> Of(char letter, std::string_view key) const {
    const auto of_axis = Number(ini_, Axis(letter), key);
    return of_axis ? of_axis : Number(ini_, Joint(FirstJointOf(letter)), key);
  }
  double Required(char letter, std::string_view key) const {
    const auto number = Of(letter, key);
    if (number) return *number;
    throw InputError({.file = file_},
                     fmt::format("{} is neither in [{}] nor in [{}]",
                                 key,
                                 Axis(letter),
                                 Joint(FirstJointOf(letter))),
                     "an INI file of LinuxCNC 2.8 or newer has it");
  }
  double StepsPerUnit(std::size_t joint) const {
    for (const char* const key :
         {"SCALE", "STEP_SCALE", "INPUT_SCALE", "OUTPUT_SCALE"}) {
      const auto scale = Number(ini_, Joint(joint), key);
      if (scale && *scale != 0) return std::abs(*scale);
    }
    throw InputError({.file = file_},
                     fmt::format("[{}] has no SCALE", Joint(joint)),
                     "steps a unit: SCALE, STEP_SCALE or INPUT_SCALE");
  }
  bool HasSwitch(std::size_t joint) const {
    return Number(ini_, Joint(joint), "HOME_SEARCH_VEL").value_or(0) != 0;
  }
  /// Without a switch of its own Z has one at the top, the others at their lower ends.
  bool IsHomeAtMax(char letter) const {
    const std::size_t joint = FirstJointOf(letter);
    if (!HasSwitch(joint)) return letter == 'Z';
    return Number(ini_, Joint(joint), "HOME_SEARCH_VEL").value_or(0) > 0;
  }
  /// Ends of the travel, its switch at one of them.
  std::array<double, 2> Travel(char letter) const {
    std::array<double, 2> ends = {Required(letter, "MIN_LIMIT"),
                                  Required(letter, "MAX_LIMIT")};
    const std::size_t joint = FirstJointOf(letter);
    const auto offset = Number(ini_, Joint(joint), "HOME_OFFSET");
    if (HasSwitch(joint) && offset) ends[IsHomeAtMax(letter) ? 1 : 0] = *offset;
    return ends;
  }
  /// How far the table is above the lower end of Z; of a Z that homes downwards it is
  /// below, out of the way.
  double Table_mm() const { return IsHomeAtMax('Z') ? kTable_mm : -kOutOfTheWay_mm; }
  /// By so much Z of the twin counts more.
  double Raised() const { return -Travel('Z')[0] - Table_mm() / mm_per_unit(); }

 private:
  // Of "trivkins coordinates=xyz" XYZ.
  std::string LettersOf(const std::string& kinematics) const {
    constexpr std::string_view kWord = "coordinates=";
    std::string letters;
    const auto at = kinematics.find(kWord);
    std::string words = at == std::string::npos ? IniValue(ini_, "TRAJ", "COORDINATES")
                                                : kinematics.substr(at + kWord.size());
    if (at != std::string::npos) words = words.substr(0, words.find(' '));
    for (const char c : words) {
      if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
        letters += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      }
    }
    return letters;
  }

  const std::string& ini_;
  std::string file_;
  bool is_inch_ = false;
  std::string letters_{};
  std::size_t num_joints_ = 0;
};

AxisSettingsText AxisOf(const Reader& read, char letter) {
  const double unit_mm = read.mm_per_unit();
  const double raised = letter == 'Z' ? read.Raised() : 0;
  const auto [min, max] = read.Travel(letter);
  const auto acceleration = read.Of(letter, "MAX_ACCELERATION");
  return {.min_mm = (min + raised) * unit_mm,
          .max_mm = (max + raised) * unit_mm,
          .steps_per_mm = read.StepsPerUnit(read.FirstJointOf(letter)) / unit_mm,
          .max_feed_mm_s = read.Required(letter, "MAX_VELOCITY") * unit_mm,
          .acceleration_mm_s2 =
              acceleration ? *acceleration * unit_mm : AxisSettingsText::kUnstated,
          .home = read.IsHomeAtMax(letter) ? HomeEnd::kMax : HomeEnd::kMin};
}

class Adapter {
 public:
  Adapter(const std::string& ini, const MachineText& drawn)
      : read_(ini, drawn.name), drawn_(drawn), ini_(ini) {}

  OwnIni Done() {
    RaiseZ();
    for (std::size_t i = 0; i < read_.num_joints(); ++i) SetJoint(i);
    LeaveOutAxes();
    SetPrograms();
    MachineText wired = drawn_;
    wired.joints.clear();
    for (std::size_t i = 0; i < read_.num_joints(); ++i) {
      wired.joints.push_back(DrawnOf(i));
    }
    return {.ini = ini_,
            .hal = HalText(wired, "caltwin"),
            .tables = std::move(tables_),
            .changes = std::move(changes_)};
  }

 private:
  void Set(const std::string& section,
           const std::string& key,
           const std::string& value) {
    ini_ = WithIniValue(ini_, section, key, value);
  }
  void Set(const std::string& section, const std::string& key, double value) {
    Set(section, key, fmt::format("{:.9g}", value));
  }

  // The drawn joint that moves the same: of two of one axis the first is the first.
  const JointText& DrawnOf(std::size_t joint) const {
    const char letter = read_.letters()[joint];
    const bool is_second = joint != read_.FirstJointOf(letter);
    const std::string drawn = LettersOf(drawn_);
    const std::size_t first = drawn.find(letter);
    const std::size_t at = is_second ? drawn.find(letter, first + 1) : first;
    if (at < drawn_.joints.size()) return drawn_.joints[at];
    throw InputError(
        {.file = drawn_.name},
        fmt::format("{} has no motor for joint {} of {}", drawn_.name, joint, letter),
        "a machine file made of this INI file: caltwin new machine NAME --from "
        "FILE.ini");
  }

  void TakeTable(std::size_t joint) {
    const std::string section = Reader::Joint(joint);
    const std::string table = IniValue(ini_, section, "COMP_FILE");
    if (table.empty()) return;
    const std::string name =
        fmt::format("{}_{}", section, table.substr(table.rfind('/') + 1));
    tables_.push_back(
        {.from = table,
         .name = name,
         .has_trims = Number(ini_, section, "COMP_FILE_TYPE").value_or(0) != 0,
         .raised = read_.letters()[joint] == 'Z' ? read_.Raised() : 0});
    Set(section, "COMP_FILE", name);
  }

  void RaiseZ() {
    const double raised = read_.Raised();
    const std::string joint = Reader::Joint(read_.FirstJointOf('Z'));
    const std::string axis = Reader::Axis('Z');
    for (const std::string& section : {joint, axis}) {
      for (const char* const key : {"MIN_LIMIT", "MAX_LIMIT", "HOME", "HOME_OFFSET"}) {
        const auto number = Number(ini_, section, key);
        if (number) Set(section, key, *number + raised);
      }
    }
    changes_.push_back(
        fmt::format("Z counts from the table: {:+.9g} beside yours; the table is {} mm "
                    "{} its lower "
                    "end",
                    raised,
                    std::abs(read_.Table_mm()),
                    read_.Table_mm() > 0 ? "above" : "below"));
  }

  void SetJoint(std::size_t joint) {
    const std::string section = Reader::Joint(joint);
    Set(section, "SCALE", read_.StepsPerUnit(joint));
    TakeTable(joint);
    for (const char* const key :
         {"HOME_INDEX_NO_ENCODER_RESET", "HOME_ABSOLUTE_ENCODER"}) {
      ini_ = WithoutIniValue(ini_, section, key);
    }
    // Without it nobody can home all joints at once.
    const std::string kSequence = "HOME_SEQUENCE";
    if (!Number(ini_, section, kSequence)) {
      Set(section, kSequence, DrawnOf(joint).home_sequence);
      changes_.push_back(fmt::format("[{}]: HOME_SEQUENCE {}, yours has none",
                                     section,
                                     DrawnOf(joint).home_sequence));
    }
    if (read_.HasSwitch(joint)) return;
    const JointText& drawn = DrawnOf(joint);
    for (const auto& [key, value] : HomingOf(drawn)) {
      if (key != kSequence) Set(section, key, value / read_.mm_per_unit());
    }
    changes_.push_back(
        fmt::format("[{}]: homes on a switch at the {} end of its travel, "
                    "yours on none",
                    section,
                    drawn.is_home_at_min ? "lower" : "upper"));
  }

  void LeaveOutAxes() {
    std::string others;
    for (std::size_t i = read_.num_joints(); i < read_.letters().size(); ++i) {
      const char letter = read_.letters()[i];
      others += std::string(others.empty() ? "" : ", ") + letter;
      ini_ = WithoutIniSection(ini_, Reader::Axis(letter));
      ini_ = WithoutIniSection(ini_, Reader::Joint(i));
    }
    if (!others.empty()) changes_.push_back("left out: axes " + others);
    const std::string mine = read_.letters().substr(0, read_.num_joints());
    const std::string both = read_.has_beam() ? " kinstype=BOTH" : "";
    Set("KINS", "KINEMATICS", "trivkins coordinates=" + mine + both);
    Set("KINS", "JOINTS", static_cast<double>(read_.num_joints()));
    Set("TRAJ", "COORDINATES", mine);
  }

  void SetPrograms() {
    ini_ = WithoutIniValue(ini_, "HAL", "");
    ini_ = WithoutIniSection(ini_, "HALUI");
    ini_ = WithoutIniSection(ini_, "APPLICATIONS");
    for (const char* const key : {"BASE_PERIOD", "SHMEM_KEY", "COMM_WAIT"}) {
      ini_ = WithoutIniValue(ini_, "EMCMOT", key);
    }
    ini_ = WithoutIniValue(ini_, "EMCIO", "DB_PROGRAM");
    Set("HAL", "HALFILE", "machine.hal");
    Set("EMC", "VERSION", "1.1");
    Set("EMCMOT", "EMCMOT", "motmod");
    if (!Number(ini_, "EMCMOT", "SERVO_PERIOD"))
      Set("EMCMOT", "SERVO_PERIOD", "1000000");
    Set("TASK", "TASK", "milltask");
    Set("EMCIO", "EMCIO", "io");
    Set("EMCIO", "TOOL_TABLE", "tool.tbl");
    changes_.emplace_back(
        "[HAL]: caltwin in place of your card and of what your HAL files connect");
  }

  Reader read_;
  const MachineText& drawn_;
  std::string ini_;
  std::vector<OwnTable> tables_{};
  std::vector<std::string> changes_{};
};

}  // namespace

std::string MachineFileOfIni(const std::string& ini,
                             const std::string& file,
                             const std::string& name) {
  const Reader read(ini, file);
  CartesianMachineText machine{.source = file, .name = name, .has_belts = false};
  for (std::size_t i = 0; i < 3; ++i) machine.axes[i] = AxisOf(read, "XYZ"[i]);
  if (read.has_beam()) {
    // Its motors stand beside the travel of X.
    constexpr double kBeside_mm = 20;
    const AxisSettingsText& x = machine.axes[0];
    machine.beam_mm = {x.min_mm - kBeside_mm, x.max_mm + kBeside_mm};
  }
  return CartesianMachineYaml(machine);
}

std::string OwnTable::Raised(const std::string& text) const {
  if (raised == 0) return text;
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double nominal = 0, forwards = 0, backwards = 0;
    if (words >> nominal >> forwards >> backwards) {
      const double by = has_trims ? 0 : raised;
      line = fmt::format(
          "{:.9g} {:.9g} {:.9g}", nominal + raised, forwards + by, backwards + by);
    }
    result += line + "\n";
  }
  return result;
}

OwnIni WithTwin(const std::string& ini, const MachineText& drawn) {
  return Adapter(ini, drawn).Done();
}

}  // namespace linuxcnc
}  // namespace caltwin
