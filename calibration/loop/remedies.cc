#include "calibration/loop/remedies.h"

#include "sim/base/require.h"

namespace caltwin {

std::string RemedyFor(Trouble trouble) {
  switch (trouble) {
    case Trouble::kNoTrigger:
      return "Probe failed to trigger: check the probe's mounting and electrical "
             "connection; verify the probe id in the configuration; make sure that the "
             "target lies beyond the expected surface.";
    case Trouble::kInconsistent:
      return "Measurements inconsistent: check the mechanics for loose parts and worn "
             "bearings; verify that the block is secured; clean the surfaces; check "
             "spindle and probe holder for runout.";
    case Trouble::kUnreasonable:
      return "Calculated value unreasonable: verify the block's dimensions as entered; "
             "check that the probe approaches from the right directions; make sure "
             "that the machine was homed before starting.";
    case Trouble::kWorse:
      return "Compensation made things worse: look for mechanical problems (binding, "
             "friction); steps/mm may be wrong by more than 5 %; verify by hand before "
             "accepting values.";
  }
  Require(false, "a trouble that has a remedy");
  return "";
}

}  // namespace caltwin
