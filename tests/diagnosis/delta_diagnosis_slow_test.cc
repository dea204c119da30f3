// A delta performs its campaigns in closed form; the diagnosis gets the rows.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/volumetric.h"
#include "sim/kinds/delta/perform.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

Machine Delta() {
  Machine machine{.kind = DeltaKind(), .own = DeltaDrawing{}};
  machine.probe.tip_radius_mm = machine.settings.tip_radius_mm = 0;
  for (AxisDrawing& axis : machine.axes) {
    axis = {.max_mm = 400,
            .lead_mm = 40,
            .is_belt = true,
            .full_steps_per_rev = 200,
            .microsteps = 256,
            .moving_mass_kg = 0.15,
            .rail_friction_n = 6};
  }
  return machine;
}

BuiltDelta Built() {
  BuiltDelta built{.build = DeltaOf(Delta()).Build()};
  built.build.model.endstop_mm = {300.2, 299.9, 300.1};
  for (double& radius : built.build.model.radius_mm) radius += 0.4;
  built.build.model.angle_rad[0] += 3e-3;
  built.bed.slope_x = 1e-3;
  return built;
}

// What campaigns read on that machine.
struct Session {
  PlannedSession planned{};
  RowTable table{};
};

Session SessionOf(const Machine& machine,
                  const BuiltDelta& built,
                  const std::vector<std::string>& campaigns,
                  const std::vector<Injected>& effects = {}) {
  Plan plan;
  for (const std::string& id : campaigns) {
    plan.campaigns.push_back(DefaultCampaign(id));
    plan.instruments[id == "delta_grid" ? "probe"
                     : id == "delta_xy" ? "camera"
                                        : "height_gauge"] = {.sigma_um = 3};
  }
  Session session{.planned = PlanSession(plan, machine, /*seed=*/1)};
  session.table = PerformDelta({.machine = machine,
                                .built = built,
                                .effects = effects,
                                .header = session.planned.header,
                                .fidelity = Fidelity::kFast},
                               session.planned.rows);
  return session;
}

Diagnosis DiagnosisOf(const BuiltDelta& built,
                      const std::vector<std::string>& campaigns,
                      const std::vector<Injected>& effects = {},
                      double rail_friction_n = 6) {
  Machine machine = Delta();
  for (AxisDrawing& axis : machine.axes) axis.rail_friction_n = rail_friction_n;
  const Session session = SessionOf(machine, built, campaigns, effects);
  return Diagnose(Observed(session.table, session.planned.header, machine, {}), {});
}

double BaselineOf(const Diagnosis& diagnosis, const std::string& name) {
  for (const BaselineLine& line : diagnosis.baseline) {
    if (line.name == name) return line.value;
  }
  return kUnknown;
}

TEST(DeltaDiagnosis, FindsNothingOnAMachineThatIsOnlyOutOfCalibration) {
  const Diagnosis diagnosis = DiagnosisOf(Built(), {"delta_grid", "delta_xy"});

  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone);
  EXPECT_NEAR(BaselineOf(diagnosis, "delta_radius"), 0.4, 0.05);
  // Against their mean.
  EXPECT_NEAR(BaselineOf(diagnosis, "endstop.a"), 0.2 - 0.2 / 3, 0.02);
  EXPECT_NEAR(BaselineOf(diagnosis, "tower_angle.a"), 0.172, 0.01);
}

TEST(DeltaDiagnosis, NamesALeaningTower) {
  BuiltDelta built = Built();
  built.build.lean_radial_rad[1] = 3e-3;
  built.build.lean_tangential_rad[1] = -2e-3;
  const Diagnosis diagnosis =
      DiagnosisOf(built, {"delta_grid", "delta_xy", "z_columns"});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  const Finding& finding = diagnosis.findings[0];
  EXPECT_EQ(finding.cause, "tower_lean");
  EXPECT_EQ(finding.axis, "b");
  ASSERT_EQ(finding.parameters.size(), 2U);
  EXPECT_NEAR(finding.parameters[0].value, 3, 3 * finding.parameters[0].sd);
  EXPECT_NEAR(finding.parameters[1].value, -2, 3 * finding.parameters[1].sd);
}

TEST(DeltaDiagnosis, NamesThePlayOfACarriage) {
  const Diagnosis diagnosis = DiagnosisOf(
      Built(),
      {"delta_grid", "z_columns", "delta_xy"},
      {{.effect = EffectIndex<CarriageBacklash>(), .axis = "c", .values = {0.06}}});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  EXPECT_EQ(diagnosis.findings[0].cause, "carriage_backlash");
  EXPECT_EQ(diagnosis.findings[0].axis, "c");
  EXPECT_NEAR(diagnosis.findings[0].parameters[0].value, 0.06, 0.01);
}

// Eight times the usual: the chain is no straight function of such a lean, and what is
// left of a straight one would be a finding of its own.
TEST(DeltaDiagnosis, TellsALargeLeanExactly) {
  BuiltDelta built = Built();
  built.build.lean_radial_rad[1] = 16e-3;
  built.build.lean_tangential_rad[1] = 8e-3;
  const Diagnosis diagnosis =
      DiagnosisOf(built, {"delta_grid", "delta_xy", "z_columns"});

  ASSERT_EQ(diagnosis.findings.size(), 1U);
  const Finding& finding = diagnosis.findings[0];
  EXPECT_EQ(finding.cause, "tower_lean");
  EXPECT_NEAR(finding.parameters[0].value, 16, 4 * finding.parameters[0].sd);
  EXPECT_NEAR(finding.parameters[1].value, 8, 4 * finding.parameters[1].sd);
}

// A part of the chain has no freedom of form that could take up the small twist.
TEST(DeltaDiagnosis, FindsASmallTwistOfTheBedBesideALargeLean) {
  BuiltDelta built = Built();
  built.build.lean_radial_rad[1] = 6e-3;
  built.bed.twist_mm = 0.02;
  const Diagnosis diagnosis =
      DiagnosisOf(built, {"delta_grid", "delta_xy", "z_columns"});

  std::vector<std::string> causes;
  for (const Finding& finding : diagnosis.findings) causes.push_back(finding.cause);
  EXPECT_THAT(causes, ::testing::UnorderedElementsAre("tower_lean", "bed_twist"));
}

// Metal near the rim pulls an inductive probe's trigger: higher there alone, and no
// bowl, which no row can tell from it but by its shape.
TEST(DeltaDiagnosis, MetalNearTheRimIsNoBowl) {
  Session session = SessionOf(Delta(), Built(), {"delta_grid", "delta_xy"});
  double rim_mm = 0;
  for (const Row& row : session.table.rows) {
    if (row.kind != RowKind::kTouch) continue;
    rim_mm = std::max(rim_mm, std::hypot(row.cmd_mm[0], row.cmd_mm[1]));
  }
  for (Row& row : session.table.rows) {
    if (row.kind != RowKind::kTouch) continue;
    const double out = std::hypot(row.cmd_mm[0], row.cmd_mm[1]) / rim_mm;
    row.value_mm += 0.15 * std::max(0.0, (out - 0.8) / 0.2);
  }
  const Diagnosis diagnosis =
      Diagnose(Observed(session.table, session.planned.header, Delta(), {}), {});

  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknownStructure);
  for (const Finding& finding : diagnosis.findings) EXPECT_EQ(finding.cause, "unknown");
}

// A machine file that claims a bed beyond any rod's reach: poses that cannot be are
// replaced by those of the rows, and the gain is still told.
TEST(DeltaDiagnosis, TellsTheGainWhereNextToNothingIsReached) {
  BuiltDelta built = Built();
  built.build.lean_radial_rad[1] = 3e-3;
  const Session session =
      SessionOf(Delta(), built, {"delta_grid", "delta_xy", "z_columns"});
  Machine boasting = Delta();
  DeltaOf(boasting).print_radius_mm = 1e5;
  const Observed observed(session.table, session.planned.header, boasting, {});

  const auto gain = VolumetricGainOf(observed, Diagnose(observed, {}), /*seed=*/1);

  ASSERT_TRUE(gain);
  EXPECT_GT(gain->before_mm, gain->after_mm);
  EXPECT_LT(gain->before_mm, 5);
}

// On free rails the carriages hang in their drives: the play costs nothing, and is
// nobody's finding.
TEST(DeltaDiagnosis, IsBlindToPlayThatWeightKeepsShut) {
  const Diagnosis diagnosis = DiagnosisOf(
      Built(),
      {"delta_grid", "z_columns"},
      {{.effect = EffectIndex<CarriageBacklash>(), .axis = "c", .values = {0.06}}},
      /*rail_friction_n=*/1);

  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone);
}

TEST(DeltaDiagnosis, SaysThatATowersRadiusIsOnlyAnotherWayToWriteTheBaseline) {
  const Diagnosis diagnosis = DiagnosisOf(Built(), {"delta_grid"});

  EXPECT_THAT(diagnosis.absorbed,
              ::testing::Contains(::testing::Field(&Absorbed::what, "tower_radius.a")));
}

// A tool that stands crooked moves every touch alike.
TEST(DeltaDiagnosis, IsBlindToAFixedTiltOfTheTool) {
  BuiltDelta built = Built();
  built.build.tool_tilt_x_rad = 0.02;
  const Diagnosis diagnosis = DiagnosisOf(built, {"delta_grid", "delta_xy"});

  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone);
}

}  // namespace
}  // namespace caltwin
