// Homing that scatters, seen by a datum touched after each homing.
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/kinds/perform.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

// Placements of other campaigns take up their homings whole; what those leave open is
// no doubt about the scatter of the others.
TEST(Homing, ScatterIsKnownAsFarAsItsHomingsTellIt) {
  constexpr double kScatter_um = 20;
  const Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  const Plan plan = ReadPlanText(
      "instruments: {probe: {sigma_um: 1}}\n"
      "campaigns:\n"
      "  - rehoming: {}\n"
      "  - plate: {grid: [5, 5], repeats: 1}\n",
      "plan.yaml");
  PlannedSession planned = PlanSession(plan, machine, 1);
  RowTable table = Perform({.machine = machine,
                            .effects = {{.effect = EffectIndex<HomingScatter>(),
                                         .axis = "x",
                                         .values = {kScatter_um}}},
                            .header = planned.header},
                           planned.rows);

  const Diagnosis diagnosis =
      Diagnose({std::move(table), planned.header, machine, {}}, {});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  const Finding& finding = diagnosis.findings[0];
  EXPECT_EQ(finding.cause, "homing_scatter");
  EXPECT_LT(finding.sds.at(0), kScatter_um / 2);
  EXPECT_NEAR(finding.effect->values.at(0), kScatter_um, 2.6 * finding.sds.at(0));
}

}  // namespace
}  // namespace caltwin
