// A triple-Z printer that measures: MuJoCo against the closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/kinds/perform.h"
#include "sim/kinds/triple_z/machine.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;

constexpr double kMust_mm = 1e-4;

Machine Printer() {
  return ReadMachine(CALTWIN_SOURCE_DIR "/models/triple_z_printer/machine.yaml");
}

PlannedSession SessionOf(const std::vector<std::string>& campaigns) {
  Plan plan;
  for (const std::string& id : campaigns) plan.campaigns.push_back(DefaultCampaign(id));
  for (PlannedCampaign& campaign : plan.campaigns) {
    if (campaign.id == "tz_grid") {
      campaign.options.Set("probe_offset_mm", std::vector<double>{0, 12});
    }
  }
  return PlanSession(plan, Printer(), /*seed=*/1);
}

std::vector<double> Read_mm(const PlannedSession& session,
                            Fidelity fidelity,
                            const std::vector<Injected>& effects,
                            const Machine& machine = Printer()) {
  const RowTable table = Perform({.machine = machine,
                                  .effects = effects,
                                  .header = session.header,
                                  .fidelity = fidelity,
                                  .is_noisy = false},
                                 session.rows);
  std::vector<double> values_mm;
  for (const Row& row : table.rows) values_mm.push_back(row.value_mm);
  return values_mm;
}

// Every value as large as is expected of it.
Injected Usual(int index, std::string_view axis) {
  Injected effect = NeutralEffect(index, axis, Printer());
  const auto parameters = EffectAt(index).parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].role == Role::kForm ||
        parameters[i].name == "true_steps_per_mm") {
      continue;
    }
    if (const auto* normal = std::get_if<Normal>(&parameters[i].prior)) {
      effect.values[i] = normal->mean + normal->sd;
    } else {
      effect.values[i] = Middle(parameters[i].prior);
    }
    if (parameters[i].if_named) effect.values[i] = *parameters[i].if_named;
  }
  if (EffectAt(index).name == "steps_per_mm") effect.values[0] *= 1.002;
  return effect;
}

// A nodding head swings its nozzle sideways, which over a bed that a raised screw tilts
// is height: second order, in no closed form. 0.2 mrad over 125 mm, on 1 mm in 195.
double Neglected_mm(int index) {
  return index == EffectIndex<AxisTwist>() ? 0.2e-3 * 125 / 195 : 0;
}

class EveryEffectOfAPrinter : public ::testing::TestWithParam<int> {};

TEST_P(EveryEffectOfAPrinter, ReadsInPhysicsAsInClosedForm) {
  static const PlannedSession kSession =
      SessionOf({"tz_grid", "tz_heights", "fixed_post", "screws_one_by_one"});
  static const auto kDrawn_mm = Read_mm(kSession, Fidelity::kFast, {});
  for (const std::string_view axis : AxesOn(EffectAt(GetParam()), TripleZKind())) {
    const std::vector<Injected> effects{Usual(GetParam(), axis)};

    const auto fast_mm = Read_mm(kSession, Fidelity::kFast, effects);
    const auto physics_mm = Read_mm(kSession, Fidelity::kPhysics, effects);

    double shown_mm = 0, worst_mm = 0;
    for (std::size_t i = 0; i < fast_mm.size(); ++i) {
      shown_mm = std::max(shown_mm, std::abs(fast_mm[i] - kDrawn_mm[i]));
      worst_mm = std::max(worst_mm, std::abs(fast_mm[i] - physics_mm[i]));
    }
    EXPECT_LT(worst_mm, kMust_mm + Neglected_mm(GetParam())) << axis;
    EXPECT_GT(shown_mm, 2 * kMust_mm) << axis;
  }
}

// Those that act in the machine and its bed; what needs a climate, times or chance has
// the same closed form in both.
std::vector<int> BuiltEffects() {
  std::vector<int> effects;
  for (int i = 0; i < static_cast<int>(kNumEffects); ++i) {
    const Effect& effect = EffectAt(i);
    const bool is_built =
        effect.bucket == Bucket::kMotion || effect.bucket == Bucket::kArtefact;
    if (AxesOn(effect, TripleZKind()).empty() || !is_built || effect.name == "unknown")
      continue;
    effects.push_back(i);
  }
  return effects;
}

INSTANTIATE_TEST_SUITE_P(Effects,
                         EveryEffectOfAPrinter,
                         ::testing::ValuesIn(BuiltEffects()),
                         [](const auto& effect) {
                           return std::string(EffectAt(effect.param).name);
                         });

TEST(TripleZMachine, AsDrawnReadsNothingButThePretravel) {
  const PlannedSession session =
      SessionOf({"tz_grid", "tz_heights", "fixed_post", "screws_one_by_one"});
  const auto values_mm = Read_mm(session, Fidelity::kPhysics, {});

  for (std::size_t i = 0; i < values_mm.size(); ++i) {
    const Row& row = session.rows[i];
    const bool is_raised = row.campaign == "screws_one_by_one";
    if (is_raised) continue;  // They read what the screw was raised.
    const double expected_mm =
        row.kind == RowKind::kTouch ? -Printer().probe.pretravel_mm : 0;
    EXPECT_NEAR(values_mm[i], expected_mm, kMust_mm / 2) << "row " << i + 1;
  }
}

// The screw of a weight of one lifts the bed by its whole travel.
TEST(TripleZMachine, ARaisedScrewLiftsTheBedOverIt) {
  const Machine machine = Printer();
  Row row{.kind = RowKind::kTouch};
  row.n = {0, 0, 1};
  row.cmd_mm = {215, 20, 0};
  row.motor_mm = {250, 251, 250};
  row.feed_mm_s = 5;
  const At at = AtOf(row, machine, machine.settings);

  const double touched_mm = ClosedFormTouch_mm(machine, {}, row, at);

  EXPECT_NEAR(touched_mm, 1 - machine.probe.pretravel_mm, 1e-9);
}

// On a plate of 6 mm the bed stands 6 mm lower as the nozzle meets it, screws apart or
// not. Where a raised screw tilts it, the plate's top moves sideways, which over the
// tilt is height: second order, in no closed form.
TEST(TripleZMachine, TouchesAPlateWhereItsTopIs) {
  constexpr double kPlate_mm = 6, kTilt = 1 / 195.0;
  constexpr double kWithin_mm = kMust_mm + kPlate_mm * kTilt * kTilt;
  PlannedSession session = SessionOf({"tz_grid", "screws_one_by_one"});
  const auto bare_mm = Read_mm(session, Fidelity::kPhysics, {});
  for (Row& row : session.rows) {
    row.cmd_mm[2] += kPlate_mm;
    for (double& motor_mm : row.motor_mm) motor_mm -= kPlate_mm;
  }

  const auto fast_mm = Read_mm(session, Fidelity::kFast, {});
  const auto physics_mm = Read_mm(session, Fidelity::kPhysics, {});

  for (std::size_t i = 0; i < bare_mm.size(); ++i) {
    EXPECT_NEAR(physics_mm[i], fast_mm[i], kWithin_mm) << "row " << i + 1;
    EXPECT_NEAR(physics_mm[i], bare_mm[i], kWithin_mm) << "row " << i + 1;
  }
}

TEST(TripleZMachine, AGaugeOnThePostDoesNotFeelTheGantry) {
  const PlannedSession session = SessionOf({"fixed_post"});
  const Injected lean{.effect = EffectIndex<Angular>(), .axis = "EAZ", .values = {300}};

  EXPECT_THAT(Read_mm(session, Fidelity::kFast, {lean}), Each(DoubleNear(0, 1e-12)));
}

// A ball's centre is at the trigger by its radius higher, and the screws turned as much
// further: a wave of theirs is met there.
TEST(TripleZMachine, AProbeWithABallTouchesByItsRadiusHigher) {
  constexpr double kRadius_mm = 0.5, kLead_mm = 4;
  Machine with_ball = Printer();
  with_ball.probe.tip_radius_mm = with_ball.settings.tip_radius_mm = kRadius_mm;
  const PlannedSession session = SessionOf({"tz_grid"});
  PlannedSession of_ball = session;
  of_ball.header.tip_radius_mm = kRadius_mm;
  const auto wave = [](double phase_deg) {
    return Injected{.effect = EffectIndex<ScrewCyclic>(),
                    .axis = "z1",
                    .values = {50, phase_deg, kLead_mm}};
  };

  const auto fast_mm = Read_mm(of_ball, Fidelity::kFast, {wave(0)}, with_ball);
  const auto physics_mm = Read_mm(of_ball, Fidelity::kPhysics, {wave(0)}, with_ball);
  const auto later_mm =
      Read_mm(session, Fidelity::kFast, {wave(-360 * kRadius_mm / kLead_mm)});

  for (std::size_t i = 0; i < fast_mm.size(); ++i) {
    EXPECT_NEAR(physics_mm[i], fast_mm[i], kMust_mm) << "row " << i + 1;
    EXPECT_NEAR(fast_mm[i], later_mm[i], kMust_mm) << "row " << i + 1;
  }
}

}  // namespace
}  // namespace caltwin
