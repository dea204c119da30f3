#include "scenarios/kinds/corners_klipper_trial.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/kinds/cartesian/corners.h"

namespace caltwin {

double CornersKlipperTrial::Flatness_mm(const Motors& by_steps) const {
  const Wiring wiring = WiringOfCorners(built_.machine);
  Motors steps = by_steps;
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const Wiring::Motor& motor = wiring.motors[static_cast<std::size_t>(i)];
    steps[i] = motor.start_steps + motor.sense * by_steps[i];
  }
  return FlatnessOfCorners_mm(built_, steps);
}

void CornersKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  const auto num =
      static_cast<Eigen::Index>(WiringOfCorners(built_.machine).motors.size());
  before_mm_ = after_mm_ = Flatness_mm(Motors::Zero(num));
  if (const auto steps = host()->MotorsNow()) after_mm_ = Flatness_mm(*steps);
}

TrueEnd CornersKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                 RunResult* result) {
  constexpr double kRecovered = 0.1, kFlat_mm = 0.01;
  result->messages.push_back(fmt::format(
      "the gantry truly hangs {:.1f} um rms from even over its bed; {:.1f} when it was "
      "switched on",
      UmFromMm(after_mm_),
      UmFromMm(before_mm_)));
  return {.figure = TrueFigure{
              .before = before_mm_,
              .after = after_mm_,
              .noise = kFlat_mm,
              .is_met = after_mm_ <= std::max(kRecovered * before_mm_, kFlat_mm)}};
}

double CornersKlipperTrial::Figure(const std::string& name,
                                   const RunResult& /*result*/) {
  if (name == "flatness_mm.rms") return after_mm_;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace caltwin
