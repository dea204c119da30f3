#include "sim/firmware/backlash.h"

#include <algorithm>
#include <cstdlib>

#include "sim/base/require.h"

namespace caltwin {

std::int64_t BacklashCompensation::Take(std::int64_t delta_steps,
                                        std::int64_t gap_steps,
                                        double factor) {
  Require(delta_steps != 0, "an axis that does not move takes no compensation");
  const int sense = delta_steps > 0 ? 1 : -1;
  const bool has_turned = sense != (sense_ == 0 ? 1 : sense_);
  if (has_turned) target_ += sense * gap_steps;
  sense_ = sense;
  const auto most = std::max<std::int64_t>(
      1,
      static_cast<std::int64_t>(static_cast<double>(std::abs(delta_steps)) / factor));
  const std::int64_t taken = std::clamp(due_steps(), -most, most);
  applied_ += taken;
  return taken;
}

void BacklashCompensation::Stopped(std::int64_t planned, std::int64_t applied) {
  applied_ += applied - planned;
}

void BacklashCompensation::Clear() {
  target_ = 0;
  applied_ = 0;
}

void BacklashCompensation::Forget() {
  target_ -= applied_;
  applied_ = 0;
}

}  // namespace caltwin
