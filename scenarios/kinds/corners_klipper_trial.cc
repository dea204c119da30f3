#include "scenarios/kinds/corners_klipper_trial.h"

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/kinds/cartesian/corners.h"

namespace caltwin {

void CornersKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  const Wiring wiring = WiringOfCorners(built().machine);
  const auto num = static_cast<Eigen::Index>(wiring.motors.size());
  const Motors switched_on = InPlant(wiring, Motors::Zero(num));
  const auto now = host()->MotorsNow();
  steps_ = now ? InPlant(wiring, *now) : switched_on;
  before_mm_ = FlatnessOfCorners_mm(built(), switched_on);
  after_mm_ = FlatnessOfCorners_mm(built(), steps_);
}

// The ball's own height does not count: a mesh has none.
double CornersKlipperTrial::TableHeight_mm(const Eigen::Vector2d& at_mm) const {
  return -OverTableAt_mm(built(), steps_, at_mm);
}

TrueEnd CornersKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                 RunResult* result) {
  result->messages.push_back(fmt::format(
      "the gantry truly hangs {:.1f} um rms from even over its bed; {:.1f} when it was "
      "switched on",
      UmFromMm(after_mm_),
      UmFromMm(before_mm_)));
  const auto mesh = JudgedMesh(result);
  return {.figure = Flattened(before_mm_, mesh ? mesh->after : after_mm_)};
}

double CornersKlipperTrial::Figure(const std::string& name, const RunResult& result) {
  if (name == "flatness_mm.rms") return after_mm_;
  return GantryKlipperTrial::Figure(name, result);
}

}  // namespace caltwin
