// A delta that measures: MuJoCo against the exact chain, and the rows it writes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/kinds/delta/perform.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

Machine Delta() {
  return ReadMachine(CALTWIN_SOURCE_DIR "/models/delta_printer/machine.yaml");
}

PlannedSession SessionOf(const std::vector<std::string>& campaigns) {
  Plan plan;
  for (const std::string& id : campaigns) plan.campaigns.push_back(DefaultCampaign(id));
  return PlanSession(plan, Delta(), /*seed=*/1);
}

std::vector<double> Read_mm(const PlannedSession& session,
                            const BuiltDelta& built,
                            Fidelity fidelity,
                            const std::vector<Injected>& effects = {}) {
  const RowTable table = PerformDelta({.machine = Delta(),
                                       .built = built,
                                       .effects = effects,
                                       .header = session.header,
                                       .fidelity = fidelity,
                                       .is_noisy = false},
                                      session.rows);
  std::vector<double> values_mm;
  for (const Row& row : table.rows) values_mm.push_back(row.value_mm);
  return values_mm;
}

// Every value a standard deviation of what is expected of it.
Injected OneSd(int index, std::string_view axis) {
  Injected effect = NeutralEffect(index, axis, Delta());
  const auto parameters = EffectAt(index).parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (const auto* normal = std::get_if<Normal>(&parameters[i].prior)) {
      effect.values[i] += normal->sd;
    }
  }
  return effect;
}

class EveryBuildOfADelta : public ::testing::TestWithParam<int> {};

TEST_P(EveryBuildOfADelta, ReadsInPhysicsAsInClosedForm) {
  constexpr double kMust_mm = 1e-4;
  static const PlannedSession kSession =
      SessionOf({"delta_grid", "delta_xy", "z_columns"});
  const Machine machine = Delta();
  const std::string_view axis = AxesOn(EffectAt(GetParam()), DeltaKind())[0];
  const Injected effect = OneSd(GetParam(), axis);
  BuiltDelta built{.build = DeltaOf(machine).Build()};
  for (const auto& [knob, by] : TurnsOf(effect)) {
    TurnKnob(knob, by, &built.build, &built.bed);
  }
  const auto drawn_mm =
      Read_mm(kSession, {.build = DeltaOf(machine).Build()}, Fidelity::kFast);
  const auto fast_mm = Read_mm(kSession, built, Fidelity::kFast);
  const auto physics_mm = Read_mm(kSession, built, Fidelity::kPhysics);

  double shown_mm = 0;
  for (std::size_t i = 0; i < fast_mm.size(); ++i) {
    shown_mm = std::max(shown_mm, std::abs(fast_mm[i] - drawn_mm[i]));
    EXPECT_NEAR(physics_mm[i], fast_mm[i], kMust_mm) << "row " << i + 1;
  }
  EXPECT_GT(shown_mm, 2 * kMust_mm);
}

std::vector<int> BuildEffects() {
  std::vector<int> effects;
  for (int i = 0; i < static_cast<int>(kNumEffects); ++i) {
    const auto axes = AxesOn(EffectAt(i), DeltaKind());
    if (axes.empty()) continue;
    if (!TurnsOf(OneSd(i, axes[0])).empty()) effects.push_back(i);
  }
  return effects;
}

INSTANTIATE_TEST_SUITE_P(Effects,
                         EveryBuildOfADelta,
                         ::testing::ValuesIn(BuildEffects()),
                         [](const auto& effect) {
                           return std::string(EffectAt(effect.param).name);
                         });

// Rails that hold more than ever hangs on them, rails that hold less, and some that do
// the one near a tower and the other far from it: MuJoCo decides by friction and
// weight, the closed form by what it says of them.
class PlayOfACarriage : public ::testing::TestWithParam<double> {};

TEST_P(PlayOfACarriage, ReadsInPhysicsAsInClosedForm) {
  constexpr double kMust_mm = 1e-4;
  static const PlannedSession kSession = SessionOf({"delta_grid", "z_columns"});
  Machine machine = Delta();
  for (AxisDrawing& tower : machine.axes) tower.rail_friction_n = GetParam();
  const Injected loose{
      .effect = EffectIndex<CarriageBacklash>(), .axis = "c", .values = {0.06}};
  const auto read = [&](Fidelity fidelity) {
    return PerformDelta({.machine = machine,
                         .built = {.build = DeltaOf(machine).Build()},
                         .effects = {loose},
                         .header = kSession.header,
                         .fidelity = fidelity,
                         .is_noisy = false},
                        kSession.rows);
  };
  const RowTable fast = read(Fidelity::kFast), physics = read(Fidelity::kPhysics);

  for (std::size_t i = 0; i < fast.rows.size(); ++i) {
    EXPECT_NEAR(physics.rows[i].value_mm, fast.rows[i].value_mm, kMust_mm)
        << "row " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Friction_n,
                         PlayOfACarriage,
                         ::testing::Values(0.5, 2.75, 6.0));

// A reversal loses the gap where the rail holds the carriage, and nothing where its
// weight does.
TEST(PerformDelta, PlayIsSeenWhereTheRailHoldsTheCarriage) {
  const PlannedSession session = SessionOf({"z_columns"});
  const auto lost_mm = [&](double friction_n) {
    Machine machine = Delta();
    machine.axes[2].rail_friction_n = friction_n;
    const RowTable table =
        PerformDelta({.machine = machine,
                      .built = {.build = DeltaOf(machine).Build()},
                      .effects = {{.effect = EffectIndex<CarriageBacklash>(),
                                   .axis = "c",
                                   .values = {0.06}}},
                      .header = session.header,
                      .is_noisy = false},
                     session.rows);
    return table.rows[0].value_mm - table.rows[1].value_mm;  // Down less up.
  };

  EXPECT_GT(lost_mm(6), 0.01);
  EXPECT_NEAR(lost_mm(1), 0, 2e-5);
}

TEST(PerformDelta, AMachineAsDrawnReadsNothing) {
  const PlannedSession session = SessionOf({"delta_grid", "ring", "z_columns"});
  const auto values_mm =
      Read_mm(session, {.build = DeltaOf(Delta()).Build()}, Fidelity::kFast);
  // Rows state their motors to a nanometre.
  EXPECT_THAT(values_mm, ::testing::Each(::testing::DoubleNear(0, 2e-6)));
}

// A lower bed is touched lower; a probe that is seen late reads lower still.
TEST(PerformDelta, TouchesReadWhereTheBedIs) {
  const PlannedSession session = SessionOf({"delta_grid"});
  BuiltDelta built{.build = DeltaOf(Delta()).Build()};
  built.bed.height_mm = -0.2;
  const Injected late{
      .effect = EffectIndex<TriggerLatency>(), .axis = "", .values = {2}};
  const auto on_time_mm = Read_mm(session, built, Fidelity::kFast);
  const auto late_mm = Read_mm(session, built, Fidelity::kFast, {late});
  for (std::size_t i = 0; i < on_time_mm.size(); ++i) {
    EXPECT_NEAR(on_time_mm[i], -0.2, 1e-8);
    EXPECT_NEAR(late_mm[i] - on_time_mm[i], -2e-3 * session.rows[i].feed_mm_s, 1e-8);
  }
}

TEST(PlanOnADelta, RowsSayWhatItsMotorsDid) {
  const PlannedSession session = SessionOf({"z_columns"});
  const Row& from_above = session.rows[0];
  const Row& from_below = session.rows[1];
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(from_above.motor_dir[i], 1);
    EXPECT_EQ(from_below.motor_dir[i], -1);
    EXPECT_GT(from_above.motor_mm[i], 0);
  }
}

TEST(PlanOnADelta, RefusesCampaignsOfAnotherMachine) {
  try {
    SessionOf({"iso230"});
    FAIL() << "planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'iso230' is no campaign on this"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("delta_grid"));
  }
}

}  // namespace
}  // namespace caltwin
