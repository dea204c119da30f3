#include "sim/controllers/linuxcnc/config.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace caltwin {
namespace linuxcnc {
namespace {

/// Off its switch, so that the end of homing is inside the travel.
constexpr double kBesideHome_mm = 2;

std::string AxisSection(const AxisText& axis) {
  return fmt::format(
      "\n[AXIS_{}]\nMIN_LIMIT = {:.9g}\nMAX_LIMIT = {:.9g}\nMAX_VELOCITY = {:.9g}\n"
      "MAX_ACCELERATION = {:.9g}\n",
      axis.letter,
      axis.min_mm,
      axis.max_mm,
      axis.max_feed_mm_s,
      axis.acceleration_mm_s2);
}

std::string HomingText(const JointText& joint) {
  std::string text;
  for (const auto& [key, value] : HomingOf(joint)) {
    text += fmt::format("{} = {:.9g}\n", key, value);
  }
  return text;
}

std::string JointTextOf(std::size_t index, const JointText& joint) {
  return fmt::format(
             "\n[JOINT_{}]\nTYPE = LINEAR\nMIN_LIMIT = {:.9g}\nMAX_LIMIT = {:.9g}\n"
             "MAX_VELOCITY = {:.9g}\nMAX_ACCELERATION = {:.9g}\nSCALE = {:.9g}\n"
             "BACKLASH = {:.9g}\nFERROR = 1\nMIN_FERROR = 0.5\n",
             index,
             joint.min_mm,
             joint.max_mm,
             joint.max_feed_mm_s,
             joint.acceleration_mm_s2,
             joint.steps_per_mm,
             joint.backlash_mm) +
         HomingText(joint);
}

std::string Trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

/// A line of an INI file.
struct IniLine {
  std::string text{};     ///< As it stands.
  std::string section{};  ///< That it begins or stands in.
  std::string key{};      ///< Empty: it sets nothing.
  bool is_header = false;
};

std::vector<IniLine> IniLines(std::string_view ini) {
  std::istringstream stream{std::string(ini)};
  std::vector<IniLine> lines;
  std::string section;
  for (std::string text; std::getline(stream, text);) {
    const std::string trimmed = Trimmed(text);
    const auto end = trimmed.find(']'), equals = trimmed.find('=');
    IniLine line{.text = text};
    line.is_header = trimmed.starts_with('[') && end != std::string::npos;
    if (line.is_header) section = trimmed.substr(1, end - 1);
    const bool is_comment = trimmed.starts_with('#') || trimmed.starts_with(';');
    if (!line.is_header && !is_comment && equals != std::string::npos) {
      line.key = Trimmed(trimmed.substr(0, equals));
    }
    line.section = section;
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

std::string LettersOf(const MachineText& machine) {
  std::string letters = machine.coordinates;
  if (!letters.empty()) return letters;
  for (const AxisText& axis : machine.axes) letters += axis.letter;
  return letters;
}

// The switch is met twice from the same side, the second time slowly: LinuxCNC takes
// the joint's place in the servo cycle that sees it close.
std::vector<std::pair<std::string, double>> HomingOf(const JointText& joint) {
  constexpr double kSearch_mm_s = 10, kLatch_mm_s = 0.5;
  const double sense = joint.is_home_at_min ? -1 : 1;
  const double search_mm_s = std::min(kSearch_mm_s, joint.max_feed_mm_s);
  return {{"HOME_OFFSET", joint.home_mm},
          {"HOME", joint.home_mm - sense * kBesideHome_mm},
          {"HOME_SEARCH_VEL", sense * search_mm_s},
          {"HOME_LATCH_VEL", sense * kLatch_mm_s},
          {"HOME_FINAL_VEL", search_mm_s},
          {"HOME_SEQUENCE", joint.home_sequence}};
}

std::string IniText(const MachineText& machine, std::string_view display) {
  double feed_mm_s = 0, acceleration_mm_s2 = 0;
  for (const AxisText& axis : machine.axes) {
    feed_mm_s = std::max(feed_mm_s, axis.max_feed_mm_s);
    acceleration_mm_s2 = std::max(acceleration_mm_s2, axis.acceleration_mm_s2);
  }
  std::string sizes;
  for (const auto& [name, value] : machine.sizes) {
    sizes += fmt::format("{} = {:.9g}\n", name, value);
  }
  std::string text = fmt::format(
      "# {0}, as its firmware believes it to be. Made by `caltwin new linuxcnc`.\n"
      "[EMC]\nMACHINE = {0}\nVERSION = 1.1\n"
      "\n[DISPLAY]\nDISPLAY = {1}\nMAX_LINEAR_VELOCITY = {2:.9g}\nPROGRAM_PREFIX = .\n"
      "\n[TASK]\nTASK = milltask\nCYCLE_TIME = 0.001\n"
      "\n[RS274NGC]\nPARAMETER_FILE = machine.var\n"
      "\n[EMCIO]\nEMCIO = io\nCYCLE_TIME = 0.01\nTOOL_TABLE = tool.tbl\n"
      "\n[EMCMOT]\nEMCMOT = motmod\nCOMM_TIMEOUT = 4\nSERVO_PERIOD = 1000000\n"
      "\n[HAL]\nHALFILE = machine.hal\n"
      "\n[KINS]\nJOINTS = {3}\nKINEMATICS = {4}\n{5}"
      "\n[TRAJ]\nCOORDINATES = {6}\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n"
      "MAX_LINEAR_VELOCITY = {2:.9g}\nMAX_LINEAR_ACCELERATION = {7:.9g}\n",
      machine.name,
      display,
      feed_mm_s,
      machine.joints.size(),
      machine.kinematics,
      sizes,
      LettersOf(machine),
      acceleration_mm_s2);
  for (const AxisText& axis : machine.axes) text += AxisSection(axis);
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    text += JointTextOf(i, machine.joints[i]);
  }
  return text;
}

std::string HalText(const MachineText& machine, std::string_view page) {
  const std::string module = machine.kinematics.substr(0, machine.kinematics.find(' '));
  std::string text = fmt::format(
      "# {}, simulated by caltwin. Made by `caltwin new linuxcnc`.\n"
      "loadrt [KINS]KINEMATICS\n"
      "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD "
      "num_joints=[KINS]JOINTS\n"
      "loadrt caltwin page={}\n\n"
      "# The machine first: what motion reads is then of this cycle.\n"
      "addf caltwin.cycle servo-thread\n"
      "addf motion-command-handler servo-thread\n"
      "addf motion-controller servo-thread\n\n"
      "net estop-out iocontrol.0.user-enable-out => caltwin.enable\n"
      "net estop-in caltwin.enabled => iocontrol.0.emc-enable-in\n"
      "net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared\n"
      "net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed\n"
      "net probe caltwin.probe => motion.probe-input\n",
      machine.name,
      page);
  for (const auto& [name, value] : machine.sizes) {
    text += fmt::format("setp {0}.{1} [KINS]{1}\n", module, name);
  }
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    text += fmt::format(
        "\nsetp caltwin.scale-{1} [JOINT_{0}]SCALE\n"
        "net command-{0} joint.{0}.motor-pos-cmd => caltwin.position-cmd-{1}\n"
        "net feedback-{0} caltwin.position-fb-{1} => joint.{0}.motor-pos-fb\n"
        "net switch-{0} caltwin.home-sw-{1} => joint.{0}.home-sw-in\n"
        "net index-{0} joint.{0}.index-enable <=> caltwin.index-enable-{1}\n"
        "setp caltwin.index-every-{1} {2:.9g}\n",
        i,
        machine.joints[i].motor,
        machine.joints[i].steps_per_turn);
  }
  return text;
}

std::vector<std::pair<std::string, std::string>> ConfigFiles(const MachineText& machine,
                                                             std::string_view display,
                                                             std::string_view page) {
  return {{"machine.ini", IniText(machine, display)},
          {"machine.hal", HalText(machine, page)},
          {"tool.tbl", "T1 P1\n"}};
}

std::vector<std::string> IniSections(std::string_view ini) {
  std::vector<std::string> sections;
  for (const IniLine& line : IniLines(ini)) {
    const bool is_new = std::ranges::find(sections, line.section) == sections.end();
    if (line.is_header && is_new) sections.push_back(line.section);
  }
  return sections;
}

std::vector<std::string> IniKeys(std::string_view ini, std::string_view section) {
  std::vector<std::string> keys;
  for (const IniLine& line : IniLines(ini)) {
    const bool is_new = std::ranges::find(keys, line.key) == keys.end();
    if (line.section == section && !line.key.empty() && is_new) {
      keys.push_back(line.key);
    }
  }
  return keys;
}

std::string IniValue(std::string_view ini,
                     std::string_view section,
                     std::string_view key) {
  for (const IniLine& line : IniLines(ini)) {
    if (line.section == section && line.key == key) {
      return Trimmed(std::string_view(line.text).substr(line.text.find('=') + 1));
    }
  }
  return "";
}

std::string WithoutIniValue(const std::string& ini,
                            std::string_view section,
                            std::string_view key) {
  std::string text;
  for (const IniLine& line : IniLines(ini)) {
    const bool is_meant = line.section == section && !line.key.empty() &&
                          (key.empty() || line.key == key);
    if (!is_meant) text += line.text + "\n";
  }
  return text;
}

std::string WithoutIniSection(const std::string& ini, std::string_view section) {
  std::string text;
  for (const IniLine& line : IniLines(ini)) {
    if (line.section != section) text += line.text + "\n";
  }
  return text;
}

bool IniIncludes(std::string_view ini) {
  return std::ranges::any_of(IniLines(ini), [](const IniLine& line) {
    return Trimmed(line.text).starts_with("#INCLUDE");
  });
}

std::string WithIniValue(const std::string& ini,
                         std::string_view section,
                         std::string_view key,
                         std::string_view value) {
  const std::string wanted = fmt::format("{} = {}\n", key, value);
  std::string text;
  bool is_written = false;
  for (const IniLine& line : IniLines(ini)) {
    const bool is_inside = line.section == section;
    if (is_inside && line.key == key) continue;
    text += line.text + "\n";
    if (!is_inside || !line.is_header || is_written) continue;
    text += wanted;
    is_written = true;
  }
  return is_written ? text : fmt::format("{}\n[{}]\n{}", text, section, wanted);
}

}  // namespace linuxcnc
}  // namespace caltwin
