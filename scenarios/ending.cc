#include "scenarios/ending.h"

namespace caltwin {

Ending EndingOf(MachineFault::Kind kind) {
  switch (kind) {
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
