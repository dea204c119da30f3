#include "calibration/loop/outcome.h"

#include "calibration/loop/controller.h"
#include "sim/base/require.h"

namespace caltwin {

std::string ToString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMeasured:
      return "measured";
    case Verdict::kApplied:
      return "applied";
    case Verdict::kRefused:
      return "refused";
    case Verdict::kRolledBack:
      return "rolled_back";
  }
  Require(false, "a verdict that has a name");
  return "";
}

Ending EndingOfFault(const MachineFault& fault) {
  switch (Classified(fault).kind) {
    case MachineFault::Kind::kAlarm:
      return IsCollision(fault) ? Ending::kCollision : Ending::kAlarm;
    case MachineFault::Kind::kRefused:
      return Ending::kRefused;
    case MachineFault::Kind::kNoTrigger:
      return Ending::kNoTrigger;
    case MachineFault::Kind::kTimeout:
    case MachineFault::Kind::kLinkLost:
      break;
  }
  return Ending::kLinkLost;
}

}  // namespace caltwin
