#include "scenarios/kinds/corners_klipper_trial.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/kinds/cartesian/corners.h"

namespace caltwin {

void CornersKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  const Wiring wiring = WiringOfCorners(built_.machine);
  const auto flatness_mm = [&](const Motors& steps) {
    return FlatnessOfCorners_mm(built_, InPlant(wiring, steps));
  };
  const auto num = static_cast<Eigen::Index>(wiring.motors.size());
  before_mm_ = after_mm_ = flatness_mm(Motors::Zero(num));
  if (const auto steps = host()->MotorsNow()) after_mm_ = flatness_mm(*steps);
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
