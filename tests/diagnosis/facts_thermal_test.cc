// Readings that follow temperatures or settle, and waves that drift: against what they
// were made of.

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr double kFrame_mm_per_k = -0.0275, kBed_mm_per_k = 0.0017;

Row TouchedAt(double z_mm) {
  Row row{
      .campaign = "warm", .kind = RowKind::kTouch, .setup = "bed", .feature = "bed"};
  row.cmd_mm = {150, 150, kUnknown};
  row.dir = {kUnknown, kUnknown, -1};
  row.n = {0, 0, 1};
  row.value_mm = z_mm;
  return row;
}

// A bed that is heated, and a frame that follows the bed slowly: both warm together.
std::vector<Row> WarmingTogether() {
  constexpr int kRows = 200;
  constexpr double kNoise_mm = 0.003, kBedTakes = 40, kFrameTakes = 50;
  Rng rng(1, 0, "facts_thermal_test");
  std::vector<Row> rows;
  double frame_c = 24;
  for (int i = 0; i < kRows; ++i) {
    const double bed_c = 25 + 75 * (1 - std::exp(-i / kBedTakes));
    if (i > 0) frame_c += (24 + 0.2 * (bed_c - 25) - frame_c) / kFrameTakes;
    rows.push_back(TouchedAt(kFrame_mm_per_k * (frame_c - 22) +
                             kBed_mm_per_k * (bed_c - 25) + kNoise_mm * rng.Normal()));
    rows.back().temp_frame_c = frame_c;
    rows.back().temp_bed_c = bed_c;
  }
  return rows;
}

TEST(ThermalFacts, TwoTemperaturesThatRiseTogetherAreToldApart) {
  const Facts facts = FactsOfRows(WarmingTogether());
  const Fact* fact = facts.Find("temperature");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "frame");
  EXPECT_THAT(fact->also, ElementsAre("bed"));
  const FactFigure& frame = fact->figures[0];
  EXPECT_NEAR(frame.value, 1e3 * kFrame_mm_per_k, 4 * frame.sd);
  EXPECT_LT(frame.sd, 0.5);
  EXPECT_NEAR(FigureOf(*fact, "second_um_per_k"), 1e3 * kBed_mm_per_k, 0.15);
  EXPECT_LT(FigureOf(*fact, "correlation"), -0.8);
}

TEST(ThermalFacts, OfTwoThermometersTheOneThatIsNotNeededIsNotNamed) {
  std::vector<Row> rows = WarmingTogether();
  Rng rng(2, 0, "facts_thermal_test");
  for (Row& row : rows) {
    row.value_mm = kFrame_mm_per_k * (row.temp_frame_c - 22) + 0.003 * rng.Normal();
  }
  const Facts facts = FactsOfRows(rows);
  ASSERT_NE(facts.Find("temperature"), nullptr);
  EXPECT_EQ(facts.Find("temperature")->word, "frame");
  EXPECT_THAT(facts.Find("temperature")->also, IsEmpty());
}

// What is left about a line wanders: neighbours say the same, and the figure is less
// sure than so many readings of white noise would make it.
TEST(ThermalFacts, AWanderMakesTheFigureLessSure) {
  const auto sd_with = [](double stays) {
    std::vector<Row> rows = WarmingTogether();
    Rng rng(3, 0, "facts_thermal_test");
    double wander_mm = 0;
    for (Row& row : rows) {
      wander_mm =
          stays * wander_mm + 0.003 * std::sqrt(1 - stays * stays) * rng.Normal();
      row.temp_bed_c = kUnknown;
      row.value_mm = kFrame_mm_per_k * (row.temp_frame_c - 22) + wander_mm;
    }
    return FactsOfRows(rows).Find("temperature")->figures[0].sd;
  };
  EXPECT_GT(sd_with(0.9), 2 * sd_with(0));
}

TEST(ThermalFacts, TheDiagnosisNamesBothWithTheSameFigures) {
  RowTable table{.rows = WarmingTogether()};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].row = static_cast<std::int64_t>(i) + 1;
  }
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  const Diagnosis diagnosis = Diagnose(Observed(table, {}, machine, {}), {});
  ASSERT_THAT(diagnosis.findings, SizeIs(2));
  std::vector<std::string> axes;
  for (const Finding& finding : diagnosis.findings) {
    EXPECT_EQ(finding.cause, "frame_temperature");
    axes.push_back(finding.axis);
    const double truth_um = finding.axis == "bed" ? 1.7 : 27.5;
    const auto& growth = finding.parameters.at(0);
    EXPECT_NEAR(growth.value, truth_um, 3 * growth.sd) << finding.axis;
    EXPECT_LT(growth.sd, 0.2 * truth_um);
  }
  EXPECT_THAT(axes, UnorderedElementsAre("frame", "bed"));
}

// Cold readings first, each nearer to the rest: as good as the last.
TEST(ThermalFacts, ReadingsThatSettleAreNoBadReadings) {
  Rng rng(4, 0, "facts_thermal_test");
  std::vector<Row> rows;
  for (int i = 0; i < 60; ++i) {
    rows.push_back(TouchedAt(0.4 * std::exp(-i / 4.0) + 0.001 * rng.Normal()));
  }
  EXPECT_EQ(FactsOfRows(rows).Find("outliers"), nullptr);
  // Among the others they would be.
  std::swap(rows[0], rows[30]);
  std::swap(rows[1], rows[45]);
  const Facts facts = FactsOfRows(rows);
  ASSERT_NE(facts.Find("outliers"), nullptr);
}

// One step of ten times the noise is a jump, wherever it is, and no drift.
TEST(ThermalFacts, AStepIsAJumpAndALineIsADrift) {
  for (const int at : {5, 12, 20}) {
    Rng rng(5, static_cast<std::uint64_t>(at), "facts_thermal_test");
    std::vector<Row> stepped, drifting;
    for (int i = 0; i < 25; ++i) {
      stepped.push_back(TouchedAt((i < at ? 0 : 0.012) + 0.001 * rng.Normal()));
      drifting.push_back(TouchedAt(0.0005 * i + 0.001 * rng.Normal()));
    }
    const Facts of_step = FactsOfRows(stepped);
    ASSERT_NE(of_step.Find("jump"), nullptr) << at;
    EXPECT_EQ(FigureOf(*of_step.Find("jump"), "row"), at + 1);
    EXPECT_NEAR(FigureOf(*of_step.Find("jump"), "change_um"), 12, 2);
    EXPECT_EQ(of_step.Find("drift"), nullptr);
    EXPECT_EQ(of_step.Find("outliers"), nullptr)
        << at << of_step.Find("outliers")->sentence;
    const Facts of_drift = FactsOfRows(drifting);
    EXPECT_EQ(of_drift.Find("jump"), nullptr) << at;
    EXPECT_NE(of_drift.Find("drift"), nullptr) << at;
  }
}

TEST(ThermalFacts, AWaveThatDriftsIsToldWithItsAxis) {
  std::vector<Row> rows;
  double phase = 0;
  for (int i = 0; i < 300; ++i) {
    phase += 0.5 * (1 + 0.1 * std::sin(i / 40.0));
    Row row{.campaign = "sweep"};
    row.cmd_mm = {0.5 * i, 20, kUnknown};
    row.dir = {1, kUnknown, kUnknown};
    row.n = {1, 0, 0};
    row.value_mm = 0.02 * std::sin(phase);
    rows.push_back(row);
  }
  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("wave");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "x");
  EXPECT_NEAR(FigureOf(*fact, "period_mm"), 0.5 * 2 * M_PI / 0.5, 0.7);
  EXPECT_NEAR(FigureOf(*fact, "size_um"), 20, 1);
}

TEST(ThermalFacts, AFewPpmAreNoCaseForStepsPerMm) {
  std::vector<Row> rows;
  for (int i = 0; i < 20; ++i) {
    Row row{.campaign = "laser"};
    row.cmd_mm = {20.0 * (i % 10), kUnknown, kUnknown};
    row.dir = {1, kUnknown, kUnknown};
    row.n = {1, 0, 0};
    row.value_mm = 1.5e-5 * row.cmd_mm[0] + (i < 10 ? 1e-5 : -1e-5);
    rows.push_back(row);
  }
  const Facts facts = FactsOfRows(rows);
  ASSERT_NE(facts.Find("scale"), nullptr);
  EXPECT_THAT(facts.Find("scale")->sentence,
              ::testing::StartsWith("X moves 15.00 +- 0.06 ppm more than commanded"));
}

}  // namespace
}  // namespace caltwin
