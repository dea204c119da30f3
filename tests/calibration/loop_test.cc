#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/loop/controller.h"
#include "calibration/loop/face.h"
#include "calibration/loop/session.h"
#include "calibration/loop/user_vars.h"
#include "calibration/procedures/catalog.h"
#include "calibration/procedures/dual_dimension.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using testing::RunStep;
using testing::ToyBench;

TEST(Controller, ReadsAxisNumbersOnlyBehindALetterThatStandsAlone) {
  const std::string reply = "Steps/mm: X: 800.125, Y: 400.000, Z: -1.5, E: 420.0";

  EXPECT_EQ(NumberAfter(reply, 'X'), 800.125);
  EXPECT_EQ(NumberAfter(reply, 'Z'), -1.5);
  EXPECT_EQ(NumberAfter("MAX 3", 'X'), std::nullopt);
}

TEST(Controller, ReadsMotorStepsBehindCountAndNothingBehindMachine) {
  const auto count = CountOf(
      "X:1.000 Y:2.000 Z:3.000 E:0.000 Count 800 -1600 2400 Machine 1.0 2.0 3.0");

  ASSERT_TRUE(count.has_value());
  EXPECT_EQ(*count, Vec3<double>(800, -1600, 2400));
}

TEST(Controller, TellsFaultsApartByTheirWords) {
  const auto kind = [](const std::string& reply) {
    return Classified({.kind = MachineFault::Kind::kRefused, .reply = reply}).kind;
  };

  EXPECT_EQ(kind("Error: G38.2: Probe was not triggered during probing move"),
            MachineFault::Kind::kNoTrigger);
  EXPECT_EQ(kind("Error: the stylus was bent beyond its overtravel"),
            MachineFault::Kind::kAlarm);
  EXPECT_EQ(kind("Error: G1: outside machine limits"), MachineFault::Kind::kRefused);
}

TEST(Face, OfABlockLooksOutwardAndOfAPocketInward) {
  const Artefact block{.id = "block", .at_mm = {150, 150, 0}};
  const Artefact pocket{.id = "pocket",
                        .type = ArtefactType::kPocket,
                        .at_mm = {100, 100, 0},
                        .size_mm = {50, 50, 20}};

  const auto outside = FacesAcross(block, Axis::kX);
  const auto inside = FacesAcross(pocket, Axis::kX);

  ASSERT_EQ(outside.size(), 2u);
  EXPECT_EQ(outside[0].feature, "block.left");
  EXPECT_EQ(outside[0].ApproachSense(Axis::kX), +1);
  EXPECT_DOUBLE_EQ(outside[0].at_mm[0], 150 - 38.1);
  ASSERT_EQ(inside.size(), 2u);
  EXPECT_EQ(inside[0].ApproachSense(Axis::kX), -1);
  EXPECT_TRUE(inside[0].internal);
}

TEST(Face, AQuarterTurnLaysTheLongSideAlongY) {
  const Artefact block{.id = "block", .at_mm = {150, 150, 0}, .turn_deg = 90};

  const auto across = FacesAcross(block, Axis::kY);

  ASSERT_EQ(across.size(), 2u);
  EXPECT_NEAR(across[1].at_mm[1] - across[0].at_mm[1], 76.2, 1e-12);
}

TEST(Face, AskewArtefactsHaveNoneAcross) {
  const Artefact block{.id = "block", .at_mm = {150, 150, 0}, .turn_deg = 30};

  EXPECT_TRUE(FacesAcross(block, Axis::kX).empty());
}

TEST(UserVars, AreTheLinesThatStartUpRunsTwiceWithoutError) {
  const Settings settings{.steps_per_mm = {800.1234, 799, 400},
                          .backlash_mm = {0.05, 0, 0.0213},
                          .probe_deflection_mm = {0.02, 0.0185, 0},
                          .tip_radius_mm = 1};

  EXPECT_THAT(UserVarsLines(settings, "2026-11-21"),
              ElementsAre("; Machine calibration data",
                          "; Last calibrated: 2026-11-21",
                          "M92 X800.1234 Y799 Z400",
                          "M425 X0.05 Y0 Z0.0213",
                          "if !exists(global.nxtProbeDeflection)",
                          "  global nxtProbeDeflection = {0.02, 0.0185, 0}",
                          "else",
                          "  set global.nxtProbeDeflection = {0.02, 0.0185, 0}",
                          "if !exists(global.nxtProbeTipRadius)",
                          "  global nxtProbeTipRadius = 1",
                          "else",
                          "  set global.nxtProbeTipRadius = 1"));
}

TEST(Rows, OfATouchHoldTheContractsSigns) {
  ToyBench toy;
  toy.machine.drives[0] = {
      .true_steps_per_mm = 800, .gap_mm = 0.06, .pretravel_mm = 0.02};

  RunStep(kDualDimension, "{axis: x, apply: false, repeats: 2}", &toy);

  const double half_step_mm = 0.5 / 800;
  double sum_mm = 0;
  for (const Row& row : toy.rows.rows) {
    EXPECT_EQ(row.kind, RowKind::kTouch);
    EXPECT_EQ(row.dir[0], -row.n[0]);
    EXPECT_EQ(row.home, "h1");
    sum_mm += row.value_mm / static_cast<double>(toy.rows.rows.size());
  }
  EXPECT_EQ(toy.rows.rows.size(), 8u);
  EXPECT_EQ(toy.rows.rows.front().feature, "block.left");
  EXPECT_NE(toy.rows.rows.front().setup, toy.rows.rows.back().setup);
  EXPECT_NEAR(sum_mm, -0.02 - 0.03, half_step_mm);
}

TEST(Rows, CiteTheSettingsTheyWereTakenWith) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[0] = 808;

  RunStep(kDualDimension, "{axis: x}", &toy);

  const std::string first = toy.rows.rows.front().settings;
  const std::string last = toy.rows.rows.back().settings;
  EXPECT_EQ(toy.bench.ledger.settings.at(first).steps_per_mm[0], 808);
  EXPECT_EQ(toy.bench.ledger.settings.at(last).steps_per_mm[0],
            toy.machine.settings.steps_per_mm[0]);
  EXPECT_NE(toy.rows.rows.front().home, toy.rows.rows.back().home);
}

TEST(Session, RollsBackWhatMadeThingsWorse) {
  ToyBench toy;
  Session session(&toy.bench, "test", "corrected", {});
  ASSERT_TRUE(session.Begin());
  const Proposal proposal{.setting = Setting::kBacklash, .after = 0.2};
  ASSERT_TRUE(session.Apply(proposal));

  const auto kept = session.KeepOrRollBack(
      proposal, 0.0, {.error_before = 0.05, .error_after = 0.15, .sd = 0.001});

  ASSERT_TRUE(kept);
  EXPECT_FALSE(*kept);
  EXPECT_EQ(toy.machine.settings.backlash_mm[0], 0);
  EXPECT_EQ(session.result().steps.back().verdict, Verdict::kRolledBack);
  ASSERT_FALSE(session.result().messages.empty());
  EXPECT_EQ(session.result().messages.back().text, RemedyFor(Trouble::kWorse));
}

// What is kept as it stood says how far from its estimate it stands.
TEST(Session, AKeptSettingIsLessSureThanItsEstimate) {
  constexpr double kSd_mm = 0.01;
  const auto conclude = [](double after_mm) {
    ToyBench toy;
    Session session(&toy.bench, "test", "corrected", {.keep_within_sd = 2});
    EXPECT_TRUE(session.Begin());
    EXPECT_TRUE(session.Apply(
        {.setting = Setting::kBacklash, .after = after_mm, .sd = kSd_mm}));
    session.Conclude("backlash.x",
                     "mm",
                     {.value = after_mm, .sd = kSd_mm, .identifiable = true},
                     /*is_setting=*/true);
    return session.result().estimates.at(0);
  };
  const Estimate kept = conclude(1.5 * kSd_mm), applied = conclude(5 * kSd_mm);

  EXPECT_EQ(applied.sd, kSd_mm);
  // P(|1.5 + z| < 3.1449) = 0.95.
  EXPECT_NEAR(kept.sd / kSd_mm, 3.1449 / 1.95996, 1e-4);
  EXPECT_EQ(kept.budget.at(1).input, "kept, not corrected");
}

// In the words of RepRapFirmware, of Klipper, and of a wire.
TEST(EndingOfFault, GoesByTheFaultsKindAndItsWords) {
  using Kind = MachineFault::Kind;
  const auto ending = [](Kind kind, const std::string& reply) {
    return EndingOfFault({.kind = kind, .reply = reply});
  };

  EXPECT_EQ(
      ending(Kind::kRefused, "Error: Probe was not triggered during probing move"),
      Ending::kNoTrigger);
  EXPECT_EQ(ending(Kind::kRefused, "!! No trigger on z after full movement"),
            Ending::kNoTrigger);
  EXPECT_EQ(ending(Kind::kNoTrigger, ""), Ending::kNoTrigger);
  EXPECT_EQ(ending(Kind::kRefused, "!! Must home axis first"), Ending::kRefused);
  EXPECT_EQ(ending(Kind::kAlarm, "Emergency stop: switch"), Ending::kAlarm);
  EXPECT_EQ(ending(Kind::kAlarm, "Emergency stop: the stylus was bent"),
            Ending::kCollision);
  EXPECT_EQ(ending(Kind::kTimeout, "no answer"), Ending::kLinkLost);
  EXPECT_EQ(ending(Kind::kLinkLost, "closed"), Ending::kLinkLost);
}

// One that such a procedure can be prepared for.
Machine MachineOf(std::string_view kind) {
  static const std::map<std::string_view, const char*> kModels = {
      {"delta", "delta_printer"}, {"motor_stage", "motor_stage"}};
  const auto model = kModels.find(kind);
  if (model == kModels.end()) return {};
  return ReadMachine(std::string(CALTWIN_SOURCE_DIR "/models/") + model->second +
                     "/machine.yaml");
}

TEST(Catalog, ExplainsEveryProcedureAndRefusesUnknownOptions) {
  for (const Procedure* procedure : AllProcedures()) {
    EXPECT_FALSE(procedure->about.empty());
    EXPECT_EQ(procedure->physics.empty(), !procedure->kind.empty());
    EXPECT_EQ(FindProcedure(procedure->name, ProceduresOf(procedure->kind)), procedure);
    Faults faults;
    procedure->prepare(ReadYamlText("{axis: x, axsi: y}", "options.yaml", &faults),
                       MachineOf(procedure->kind));
    EXPECT_GE(faults.size(), 1u) << procedure->name;
  }
  EXPECT_EQ(FindProcedure("no_such_procedure", AllProcedures()), nullptr);
}

}  // namespace
}  // namespace caltwin
