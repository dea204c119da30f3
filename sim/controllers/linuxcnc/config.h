#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace caltwin {
namespace linuxcnc {

/// Where the tool may be sent along X, Y or Z.
struct AxisText {
  char letter = 'X';
  double min_mm = 0, max_mm = 0;
  double max_feed_mm_s = 10, acceleration_mm_s2 = 100;
};

/// One joint, in mm.
struct JointText {
  int motor = 0;  ///< Of the board: the component's pins of that number.
  double min_mm = 0, max_mm = 0;  ///< Where it may be sent.
  double home_mm = 0;             ///< Where its switch closes.
  bool is_home_at_min = true;
  /// The lowest is homed first; joints of the same negative one move to their homes
  /// together.
  int home_sequence = 0;
  double max_feed_mm_s = 10, acceleration_mm_s2 = 100;
  double steps_per_mm = 1;    ///< `SCALE`
  double steps_per_turn = 0;  ///< Of its motor, from index pulse to index pulse.
  double backlash_mm = 0;     ///< `BACKLASH`: what its firmware takes for the play.
};

/// A machine as LinuxCNC is told of it.
struct MachineText {
  std::string name{};
  std::string kinematics = "trivkins coordinates=XYZ";  ///< The module, its parameters.
  std::string coordinates{};  ///< The axis of each joint; empty: the axes' letters.
  std::vector<AxisText> axes{};
  std::vector<JointText> joints{};
  /// Sizes of those kinematics, `R = 130`: [KINS] has them, and its pins of that name
  /// are set to them.
  std::vector<std::pair<std::string, double>> sizes{};
};

/// How a joint homes on its switch: keys and values of its section of an INI file.
std::vector<std::pair<std::string, double>> HomingOf(const JointText& joint);

/// Axes of the joints, in their order: "XYYZ".
std::string LettersOf(const MachineText& machine);

/// The text of its INI file. `display`: the program that its operator sits at.
std::string IniText(const MachineText& machine, std::string_view display);

/// machine.hal, which that file names: caltwin's component in place of a card.
/// @param page  as `caltwin serve --linuxcnc` was given
std::string HalText(const MachineText& machine, std::string_view page);

/// All files of such a configuration, names and texts, the INI file first.
std::vector<std::pair<std::string, std::string>> ConfigFiles(const MachineText& machine,
                                                             std::string_view display,
                                                             std::string_view page);

/// @name What an INI file has; each once, in its order
std::vector<std::string> IniSections(std::string_view ini);
std::vector<std::string> IniKeys(std::string_view ini, std::string_view section);
/// What stands there first, as LinuxCNC takes it; empty: nothing.
std::string IniValue(std::string_view ini,
                     std::string_view section,
                     std::string_view key);
/// Whether it takes in other files.
bool IniIncludes(std::string_view ini);

/// `ini` with that value in that section, in place of every one that was there; a
/// section or a key that is missing is added.
std::string WithIniValue(const std::string& ini,
                         std::string_view section,
                         std::string_view key,
                         std::string_view value);

/// `ini` without that key of a section; without any key of it where that is empty.
std::string WithoutIniValue(const std::string& ini,
                            std::string_view section,
                            std::string_view key);
/// `ini` without that section.
std::string WithoutIniSection(const std::string& ini, std::string_view section);

}  // namespace linuxcnc
}  // namespace caltwin
