#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace caltwin {
namespace linuxcnc {

/// One joint of a machine whose joints are its axes, in mm.
struct JointText {
  char axis = 'X';
  double min_mm = 0, max_mm = 0;  ///< Where it may be sent.
  double home_mm = 0;             ///< Where its switch closes.
  bool is_home_at_min = true;
  int home_sequence = 0;  ///< The lowest is homed first.
  double max_feed_mm_s = 10, acceleration_mm_s2 = 100;
  double steps_per_mm = 1;  ///< `SCALE`
  double backlash_mm = 0;   ///< `BACKLASH`: what its firmware takes for the play.
};

/// The text of the INI file of a machine whose joints are its axes (`trivkins`).
/// `display`: the program that its operator sits at.
std::string IniText(std::string_view machine,
                    const std::vector<JointText>& joints,
                    std::string_view display);

/// machine.hal, which that file names: caltwin's component in place of a card.
/// @param page  as `caltwin serve --linuxcnc` was given
std::string HalText(std::string_view machine,
                    std::size_t num_joints,
                    std::string_view page);

/// All files of such a configuration, names and texts, the INI file first.
std::vector<std::pair<std::string, std::string>> ConfigFiles(
    std::string_view machine,
    const std::vector<JointText>& joints,
    std::string_view display,
    std::string_view page);

/// `ini` with that value in that section, in place of every one that was there; a
/// section or a key that is missing is added.
std::string WithIniValue(const std::string& ini,
                         std::string_view section,
                         std::string_view key,
                         std::string_view value);

}  // namespace linuxcnc
}  // namespace caltwin
