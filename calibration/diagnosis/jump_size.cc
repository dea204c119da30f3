#include "calibration/diagnosis/jump_size.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

std::string RemarkOnJump(const Machine& machine, const Finding& finding) {
  constexpr double kSteps = 4;
  constexpr double kFar_sds = 3, kFarOfTurn = 0.1;
  const auto axis = AxisNamed(finding.axis);
  const bool is_jump = finding.cause == "missed_steps" && !finding.parameters.empty();
  if (!is_jump || !axis || !machine.kind->motors().empty()) return "";
  const AxisDrawing& drawing = machine.axis(*axis);
  const double turn_um =
      UmFromMm(kSteps * drawing.lead_mm / drawing.full_steps_per_rev);
  const FindingParameter& jump = finding.parameters.front();
  const double turns = std::max(1.0, std::round(std::abs(jump.value) / turn_um));
  const double apart_um = std::abs(std::abs(jump.value) - turns * turn_um);
  if (!(apart_um > std::max(kFar_sds * jump.sd, kFarOfTurn * turn_um))) return "";
  return fmt::format(
      "The jump of {} is no whole number of {:.0f} full steps ({:.0f} um), by which a "
      "motor slips: a block that was pushed, a gauge set anew or a slipping coupling "
      "looks the same. What homing takes away is the motor's",
      WithSd(jump.value, jump.sd, "um"),
      kSteps,
      turn_um);
}

}  // namespace caltwin
