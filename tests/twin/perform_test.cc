#include "sim/kinds/perform.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/kinds/readings.h"
#include "sim/twin/measuring_machine.h"
#include "tests/twin/measured_rows.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr double kMust_mm = 0.5e-3;  // docs/fidelities.md.
constexpr double kAim_mm = 0.1e-3;

Row Position(double x_mm, double dir) {
  Row row{.row = 1, .cmd_mm = {x_mm, 150, 60}, .dir = {dir, 0, 0}, .n = {1, 0, 0}};
  return row;
}

// A face that looks along +-x, touched from outside.
Row TouchAt(double x_mm, double n) {
  return {.row = 1,
          .kind = RowKind::kTouch,
          .cmd_mm = {x_mm, 150, 20},
          .dir = {-n, 0, 0},
          .feed_mm_s = 1,
          .n = {n, 0, 0}};
}

PerformConfig Noiseless(std::vector<Injected> effects, Fidelity fidelity) {
  return {.machine = Gantry(),
          .effects = std::move(effects),
          .fidelity = fidelity,
          .is_noisy = false};
}

double ReadingOf(const PerformConfig& config, const Row& row) {
  return Perform(config, {row}).rows[0].value_mm;
}

Injected Effect(const char* name, const char* axis, std::vector<double> values) {
  return {.effect = *FindEffect(name), .axis = axis, .values = std::move(values)};
}

// The row of a session in which an effect shows most.
std::size_t WhereItShows(const PlannedSession& session,
                         const std::vector<Injected>& effects) {
  const auto plain_mm = Read_mm(session, {}, Fidelity::kFast);
  const auto with_mm = Read_mm(session, effects, Fidelity::kFast);
  std::size_t most = 0;
  for (std::size_t i = 0; i < with_mm.size(); ++i) {
    if (std::abs(with_mm[i] - plain_mm[i]) > std::abs(with_mm[most] - plain_mm[most])) {
      most = i;
    }
  }
  return most;
}

class EveryEffectShows : public ::testing::TestWithParam<int> {};

TEST_P(EveryEffectShows, InPhysicsAsInClosedForm) {
  static const PlannedSession kSession = SomeOfEverything();
  const PerformConfig config{
      .machine = Gantry(),
      .effects = {LargeEffect(GetParam(), EffectAt(GetParam()).axes[0], Gantry())},
      .header = kSession.header,
      .is_noisy = false};
  const std::size_t i = WhereItShows(kSession, config.effects);
  const Row& row = kSession.rows[i];
  const Readings readings(config, kSession.rows);
  MeasuringMachine machine(config.machine, config.effects);

  const double physics_mm = row.kind == RowKind::kTouch
                                ? machine.Touch_mm(row, readings.AtFor(row))
                                : machine.Position_mm(readings.AtFor(row));

  const auto plain_mm = Read_mm(kSession, {}, Fidelity::kFast);
  const auto with_mm = Read_mm(kSession, config.effects, Fidelity::kFast);
  if (GetParam() != EffectIndex<TriggerScatter>()) {
    EXPECT_GT(std::abs(with_mm[i] - plain_mm[i]), 2 * kMust_mm) << "shows nowhere";
  }
  EXPECT_NEAR(physics_mm,
              with_mm[i],
              kMust_mm + Neglected_mm(config.effects[0], row, config.machine))
      << "row " << row.row << " of " << row.campaign;
}

INSTANTIATE_TEST_SUITE_P(Effects,
                         EveryEffectShows,
                         ::testing::ValuesIn(EffectsOfAGantry()),
                         [](const auto& effect) {
                           return std::string(EffectAt(effect.param).name);
                         });

class Performed : public ::testing::TestWithParam<Fidelity> {};

TEST_P(Performed, AnAxisThatGoesTooFarReadsPlusByGaugeAndMinusByTouch) {
  const auto config = Noiseless({Effect("steps_per_mm", "x", {792})}, GetParam());
  const double too_far = 800.0 / 792 - 1;

  EXPECT_NEAR(ReadingOf(config, Position(200, 1)), 200 * too_far, kAim_mm);
  // The probe triggers 0.02 mm late in its own coordinates, which count too long steps.
  const double reported_mm = ReadingOf(config, TouchAt(200, -1));
  EXPECT_NEAR(reported_mm, (200 - 1 + 0.02) / (1 + too_far) * -1 + 200 - 1, 1e-3);
}

TEST_P(Performed, ABacklashReadsHalfItsWidthBySense) {
  const auto config = Noiseless({Effect("backlash", "x", {0.08})}, GetParam());

  EXPECT_NEAR(ReadingOf(config, Position(120, 1)), -0.04, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, Position(120, -1)), 0.04, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, TouchAt(120, -1)), -0.04 - 0.02, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, TouchAt(120, 1)), -0.04 - 0.02, kAim_mm);
}

TEST_P(Performed, AnUnknownSenseStandsInTheMiddleOfItsGap) {
  const auto config = Noiseless({Effect("backlash", "x", {0.08})}, GetParam());
  Row position = Position(120, 1);
  Row touch = TouchAt(120, 1);
  position.dir = touch.dir = {kUnknown, kUnknown, kUnknown};

  EXPECT_NEAR(ReadingOf(config, position), 0, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, touch), -0.02, kAim_mm);
}

TEST_P(Performed, AReleaseLagsTheOtherWayAndComesBeforeTheTrigger) {
  const auto config = Noiseless({Effect("backlash", "x", {0.08})}, GetParam());
  Row release = TouchAt(120, 1);
  release.dir = {1, 0, 0};

  // Outwards the carriage hangs back on the other side; hysteresis 0.002.
  EXPECT_NEAR(ReadingOf(config, release), 0.04 - 0.018, kMust_mm);
}

TEST_P(Performed, TheFirmwaresCompensationTakesFromTheGap) {
  auto config = Noiseless({Effect("backlash", "x", {0.08})}, GetParam());
  config.header.settings["1"].backlash_mm["x"] = 0.06;
  Row row = Position(120, 1);
  row.settings = "1";

  EXPECT_NEAR(ReadingOf(config, row), -0.01, kAim_mm);
}

TEST_P(Performed, AWrongTipRadiusInTheSettingsShowsInEveryTouch) {
  auto config = Noiseless({}, GetParam());
  config.header.tip_radius_mm = 1.5;

  EXPECT_NEAR(ReadingOf(config, TouchAt(120, 1)), -0.02 - 0.5, kAim_mm);
}

TEST_P(Performed, ANearDiagonalFaceIsTouchedAlongItsNormal) {
  const auto config = Noiseless({Effect("backlash", "y", {0.1})}, GetParam());
  Row row = TouchAt(120, 1);
  row.n = {0.6, -0.8, 0};
  row.dir = {-1, 1, 0};

  EXPECT_NEAR(ReadingOf(config, row), -0.02 - 0.8 * 0.05, kAim_mm);
}

TEST_P(Performed, MissingColumnsAreMidTravelAndRest) {
  const auto config = Noiseless({}, GetParam());
  Row row{.row = 1, .kind = RowKind::kTouch, .n = {0, 0, 1}};
  row.cmd_mm[2] = 10;

  EXPECT_NEAR(ReadingOf(config, row), -0.02, kAim_mm);
}

TEST_P(Performed, TheSameSeedGivesTheSameBytes) {
  const PlannedSession session = SomeOfEverything();
  std::vector<Row> few(session.rows.begin(), session.rows.begin() + 6);
  PerformConfig config = Noiseless({Effect("trigger_scatter", "", {3})}, GetParam());
  config.is_noisy = true;

  const auto once = Perform(config, few);
  const auto again = Perform(config, few);
  config.seed = 2;
  const auto other = Perform(config, few);

  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(once.rows[i].value_mm, again.rows[i].value_mm);
  }
  EXPECT_NE(once.rows[0].value_mm, other.rows[0].value_mm);
}

INSTANTIATE_TEST_SUITE_P(,
                         Performed,
                         ::testing::Values(Fidelity::kFast, Fidelity::kPhysics),
                         [](const auto& test) { return ToString(test.param); });

TEST(Perform, ATouchIsCountedInWholeSteps) {
  PerformConfig config = Noiseless({}, Fidelity::kFast);
  config.is_noisy = true;

  const double reported_mm = ReadingOf(config, TouchAt(120.0004, 1)) + 120.0004 + 1;

  EXPECT_NEAR(reported_mm * 800, std::round(reported_mm * 800), 1e-6);
}

TEST(Perform, AnInstrumentScattersAndRoundsAsDeclared) {
  PerformConfig config = Noiseless({}, Fidelity::kFast);
  config.is_noisy = true;
  config.header.instruments["laser"] = {
      .kind = "laser", .sigma_um = 2, .resolution_um = 0.5};
  std::vector<Row> rows(4000, Position(100, 1));

  double sum2 = 0;
  for (const Row& row : Perform(config, rows).rows) {
    const double um = row.value_mm * 1e3;
    EXPECT_NEAR(um, std::round(um / 0.5) * 0.5, 1e-9);
    sum2 += um * um;
  }

  const double expected_um2 = 2 * 2 + 0.5 * 0.5 / 12;
  EXPECT_NEAR(sum2 / 4000, expected_um2, 4 * expected_um2 * std::sqrt(2.0 / 4000));
}

TEST(Perform, WithoutADirectionARowIsRefused) {
  Row row = Position(100, 1);
  row.n = {kUnknown, kUnknown, kUnknown};
  row.place = {.file = "data.csv", .line = 7};

  try {
    Perform(Noiseless({}, Fidelity::kFast), {row});
    FAIL() << "no fault";
  } catch (const InputError& error) {
    EXPECT_THAT(error.faults()[0], testing::StartsWith("data.csv:7"));
  }
}

// The gantry with its model changed as text, as a person would.
Machine WithModel(const std::string& from, const std::string& to) {
  std::string text = ReadTextFile("models/gantry_router/model.xml", 1 << 20);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  Machine machine = Gantry();
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  machine.model = fs::temp_directory_path() / (std::string(test->name()) + ".xml");
  WriteTextFile(machine.model, text);
  return machine;
}

TEST(AModelEditedByHand, WithAGapReadsItWithoutBeingTold) {
  PerformConfig config = Noiseless({}, Fidelity::kPhysics);
  config.machine = WithModel("<fixed name=\"x_play\">",
                             "<fixed name=\"x_play\" limited=\"true\" "
                             "range=\"-.00005 .00005\">");
  std::string text = ReadTextFile(config.machine.model, 1 << 20);
  const std::string rigid = "<tendon name=\"x_rigid\"";
  text.replace(text.find(rigid), rigid.size(), rigid + " active=\"false\"");
  WriteTextFile(config.machine.model, text);

  EXPECT_NEAR(ReadingOf(config, Position(120, 1)), -0.05, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, Position(120, -1)), 0.05, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, TouchAt(120, 1)), -0.05 - 0.02, kAim_mm);
}

TEST(AModelEditedByHand, WithALongerLeadReadsItsScale) {
  PerformConfig config = Noiseless({}, Fidelity::kPhysics);
  config.machine = WithModel("<joint joint=\"x_nut\" coef=\"-1\"/>",
                             "<joint joint=\"x_nut\" coef=\"-1.001\"/>");

  EXPECT_NEAR(ReadingOf(config, Position(200, 1)), 0.2, kAim_mm);
  EXPECT_NEAR(ReadingOf(config, TouchAt(200, 1)), -0.2 * 201 / 200 - 0.02, kMust_mm);
}

TEST(AModelEditedByHand, WithATurnedAxisReadsItsSquareness) {
  PerformConfig config = Noiseless({}, Fidelity::kPhysics);
  config.machine = WithModel("<joint name=\"y\" class=\"rail\" axis=\"0 1 0\"",
                             "<joint name=\"y\" class=\"rail\" axis=\"-.001 1 0\"");
  Row low = Position(150, 1);
  Row high = low;
  low.cmd_mm[1] = 50;
  high.cmd_mm[1] = 250;

  EXPECT_NEAR(ReadingOf(config, high) - ReadingOf(config, low), -0.2, kAim_mm);
}

TEST(AModelEditedByHand, WithATiltedTableTiltsWhatStandsOnIt) {
  PerformConfig config = Noiseless({}, Fidelity::kPhysics);
  config.machine =
      WithModel("<body name=\"table\">", "<body name=\"table\" euler=\"0 -.001 0\">");
  Row left{.row = 1, .kind = RowKind::kTouch, .cmd_mm = {50, 150, 0}, .n = {0, 0, 1}};
  Row right = left;
  right.cmd_mm[0] = 250;

  EXPECT_NEAR(ReadingOf(config, right) - ReadingOf(config, left), 0.2, kAim_mm);
}

TEST(AModelEditedByHand, WithAShapeOnTheTableIsTouchedThereAndTurnsWithThePlate) {
  PerformConfig config = Noiseless({}, Fidelity::kPhysics);
  config.machine = WithModel(
      "<body name=\"table\">",
      "<body name=\"table\"><geom type=\"box\" pos=\".15 .15 -.01\" size=\".2 .2 .01\" "
      "contype=\"2\"/><geom type=\"box\" pos=\".25 .15 -.0099\" size=\".03 .03 .01\" "
      "contype=\"2\"/>");
  Row row{.row = 1, .kind = RowKind::kTouch, .cmd_mm = {250, 150, 0}, .n = {0, 0, 1}};
  EXPECT_NEAR(ReadingOf(config, row), 0.1 - 0.02, kAim_mm);
  row.artefact_turn_deg = 90;
  EXPECT_NEAR(ReadingOf(config, row), -0.02, kAim_mm);
  row.cmd_mm = {150, 250, 0};
  EXPECT_NEAR(ReadingOf(config, row), 0.1 - 0.02, kAim_mm);
}

}  // namespace
}  // namespace caltwin
