#include "scenarios/ending.h"

#include "calibration/loop/controller.h"

namespace caltwin {

Ending EndingOf(const MachineFault& fault) {
  if (IsCollision(fault)) return Ending::kCollision;
  switch (Classified(fault).kind) {
    case MachineFault::Kind::kAlarm:
      return Ending::kAlarm;
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
