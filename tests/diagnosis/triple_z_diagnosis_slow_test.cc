// Pivots and wiring of a bed on three screws: found as large as they are.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/kinds/perform.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

Machine Printer() {
  return ReadMachine(CALTWIN_SOURCE_DIR "/models/triple_z_printer/machine.yaml");
}

Observed Measured(const std::vector<Injected>& truth, bool one_by_one = true) {
  const Plan plan =
      ReadPlanText(std::string("instruments: {probe: {sigma_um: 5}}\n"
                               "campaigns:\n"
                               "  - tz_grid\n") +
                       (one_by_one ? "  - screws_one_by_one: {travel_mm: 1}\n" : ""),
                   "plan.yaml");
  PlannedSession planned = PlanSession(plan, Printer(), 1);
  RowTable table = Perform({.machine = Printer(),
                            .effects = truth,
                            .header = planned.header,
                            .fidelity = Fidelity::kFast},
                           planned.rows);
  return {std::move(table), planned.header, Printer(), {}};
}

Injected Pivot(double dx_mm, double dy_mm) {
  return {
      .effect = EffectIndex<PivotPosition>(), .axis = "z2", .values = {dx_mm, dy_mm}};
}

Injected Swapped(const std::string& pair) {
  return {.effect = EffectIndex<MotorsSwapped>(), .axis = pair, .values = {1}};
}

const Finding* FindingNamed(const Diagnosis& diagnosis, const std::string& cause) {
  const auto found = std::ranges::find(diagnosis.findings, cause, &Finding::cause);
  return found == diagnosis.findings.end() ? nullptr : &*found;
}

// By no more than 4 standard deviations as stated, and those below half a millimetre.
void ExpectFound(const Diagnosis& diagnosis, const Injected& truth) {
  const Finding* found =
      FindingNamed(diagnosis, std::string(EffectAt(truth.effect).name));
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->axis, truth.axis);
  for (std::size_t p = 0; p < truth.values.size(); ++p) {
    const FindingParameter& parameter = found->parameters[p];
    EXPECT_NEAR(parameter.value, truth.values[p], 4 * parameter.sd) << parameter.name;
    EXPECT_LT(parameter.sd, 0.5) << parameter.name;
  }
}

TEST(TripleZDiagnosis, APivotFarFromTheDrawingIsFoundWhereItIs) {
  const std::vector<std::pair<double, double>> pivots_mm = {
      {-60, 0}, {-25, 18.33}, {30, -20}};
  for (const auto& [dx_mm, dy_mm] : pivots_mm) {
    SCOPED_TRACE(dx_mm);
    const Observed observed = Measured({Pivot(dx_mm, dy_mm)});
    const Diagnosis diagnosis = Diagnose(observed, {});
    EXPECT_EQ(diagnosis.findings.size(), 1U);
    ExpectFound(diagnosis, Pivot(dx_mm, dy_mm));

    // What it is said to do is what the model says of the values found.
    const Finding& finding = diagnosis.findings.at(0);
    const Eigen::VectorXd exact_mm =
        observed.residual_mm() - observed.With({*finding.effect}).residual_mm();
    EXPECT_LT((finding.change_mm - exact_mm).cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST(TripleZDiagnosis, APivotBesideSwappedMotorsIsFoundWhereItIs) {
  const Diagnosis diagnosis =
      Diagnose(Measured({Swapped("z1z3"), Pivot(-25, 18.33)}), {});
  EXPECT_EQ(diagnosis.findings.size(), 2U);
  ExpectFound(diagnosis, Swapped("z1z3"));
  ExpectFound(diagnosis, Pivot(-25, 18.33));
}

// Every wiring but the right one, rings as rings.
TEST(TripleZDiagnosis, EveryWiringIsNamed) {
  for (const std::string_view wiring : MotorsSwapped::kWirings) {
    SCOPED_TRACE(wiring);
    const Injected swapped = Swapped(std::string(wiring));
    const Diagnosis diagnosis = Diagnose(Measured({swapped}), {});
    EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNamed);
    EXPECT_EQ(diagnosis.findings.size(), 1U);
    ExpectFound(diagnosis, swapped);
    EXPECT_EQ(diagnosis.findings.at(0).candidates.size(), 1U);
  }
}

TEST(TripleZDiagnosis, APivotBesideARingOfMotorsIsFoundWhereItIs) {
  const Diagnosis diagnosis =
      Diagnose(Measured({Swapped("z1z3z2"), Pivot(-25, 18.33)}), {});
  EXPECT_EQ(diagnosis.findings.size(), 2U);
  ExpectFound(diagnosis, Swapped("z1z3z2"));
  ExpectFound(diagnosis, Pivot(-25, 18.33));
}

// So stiffly held that a tilt is left by nine tenths: far from proportional.
TEST(TripleZDiagnosis, AnOverconstrainedBedIsNamedWithItsStiffness) {
  const Injected held{
      .effect = EffectIndex<OverconstrainedBed>(), .axis = "", .values = {1500}};
  const Diagnosis diagnosis = Diagnose(Measured({held}), {});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  const Finding& found = diagnosis.findings[0];
  EXPECT_EQ(found.cause, "overconstrained_bed");
  ASSERT_EQ(found.parameters.size(), 1U);
  EXPECT_NEAR(found.parameters[0].value, 1500, 4 * found.parameters[0].sd);
  EXPECT_LT(found.parameters[0].sd, 100);
}

TEST(TripleZDiagnosis, WhereNoScrewMovesAloneItSaysWhatCannotBeSeen) {
  const auto absorbed = [](const Diagnosis& diagnosis) {
    std::vector<std::string> names;
    for (const Absorbed& one : diagnosis.absorbed) names.push_back(one.what);
    return names;
  };
  const Diagnosis alike =
      Diagnose(Measured({Swapped("z1z2")}, /*one_by_one=*/false), {});
  EXPECT_THAT(absorbed(alike), Contains("pivot_position.z1"));
  EXPECT_THAT(absorbed(alike), Contains("motors_swapped.z2z3"));
  EXPECT_THAT(absorbed(alike), Contains("overconstrained_bed"));
  EXPECT_THAT(alike.remarks, Contains(HasSubstr("screws_one_by_one")));

  const Diagnosis alone = Diagnose(Measured({}), {});
  EXPECT_THAT(absorbed(alone), Not(Contains("pivot_position.z1")));
  EXPECT_THAT(alone.remarks, Not(Contains(HasSubstr("screws_one_by_one"))));
}

}  // namespace
}  // namespace caltwin
