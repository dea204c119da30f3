#include "calibration/loop/outcome.h"

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

}  // namespace caltwin
