#include "calibration/diagnosis/settings_of_rows.h"

#include "sim/measure/in_force.h"

namespace caltwin {

Settings SettingsOfRows(const Observed& observed) {
  const auto& stated = observed.header().settings;
  return InForce(observed.header(),
                 observed.machine(),
                 stated.size() == 1 ? stated.begin()->first : "");
}

}  // namespace caltwin
