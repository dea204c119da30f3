#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/estimate/observability.h"

namespace caltwin {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr double kSigma_mm = 0.001;

// Rows in mm per mm of: pre-travel, backlash, tip, scale over 100 mm.
const std::vector<UnknownColumn> kX = {
    {"probe_pretravel.x"}, {"backlash.x"}, {"tip_size"}, {"steps_per_mm.x"}};
const Eigen::RowVector4d kSpan25(-2, -1, 2, -0.254);
const Eigen::RowVector4d kSpan76(-2, -1, 2, -0.762);
const Eigen::RowVector4d kRelease(0, 1, 0, 0);
const Eigen::RowVector4d kCalliperOnBall(0, 0, 1, 0);

Eigen::MatrixXd Rows(std::initializer_list<Eigen::RowVector4d> rows) {
  Eigen::MatrixXd jacobian(rows.size(), 4);
  Eigen::Index at = 0;
  for (const Eigen::RowVector4d& row : rows) jacobian.row(at++) = row / kSigma_mm;
  return jacobian;
}

TEST(Observability, SpansTellPretravelBacklashAndTipOnlyTogether) {
  const ObservabilityReport report = Observe(Rows({kSpan25, kSpan76}), kX);

  EXPECT_THAT(report.determined, ElementsAre("steps_per_mm.x"));
  ASSERT_EQ(report.blind.size(), 2u);
  for (const Observability& blind : report.blind) {
    EXPECT_EQ(blind.statement, "probe_pretravel.x + backlash.x / 2 - tip_size only");
  }
}

TEST(Observability, BlindDirectionIsAUnitVectorAlongWhichNothingChanges) {
  Eigen::MatrixXd known_tip = Rows({kSpan25, kSpan76, kCalliperOnBall});

  const ObservabilityReport report = Observe(known_tip, kX);

  ASSERT_EQ(report.blind.size(), 1u);
  EXPECT_EQ(report.blind[0].statement, "probe_pretravel.x + backlash.x / 2 only");
  const auto& direction = report.blind[0].blind_direction;
  ASSERT_EQ(direction.size(), 2u);
  EXPECT_NEAR(direction.at("probe_pretravel.x"), 1 / std::sqrt(5), 1e-9);
  EXPECT_NEAR(direction.at("backlash.x"), -2 / std::sqrt(5), 1e-9);
}

TEST(Observability, AdviceNamesTheMeasurementThatTells) {
  const ObservabilityReport report =
      Observe(Rows({kSpan25, kSpan76, kCalliperOnBall}), kX);

  EXPECT_THAT(report.advice, Contains(HasSubstr("release the same face")));
  EXPECT_THAT(report.advice, Not(Contains(HasSubstr("calliper"))));
}

TEST(Observability, ReleaseAndACalliperOnTheBallTellEverything) {
  const ObservabilityReport report =
      Observe(Rows({kSpan25, kSpan76, kRelease, kCalliperOnBall}), kX);

  EXPECT_THAT(report.blind, IsEmpty());
  EXPECT_THAT(report.advice, IsEmpty());
  EXPECT_THAT(report.determined,
              UnorderedElementsAre(
                  "probe_pretravel.x", "backlash.x", "tip_size", "steps_per_mm.x"));
}

TEST(Observability, OneSpanLeavesTheScaleInTheSumToo) {
  const ObservabilityReport report = Observe(Rows({kSpan25}), kX);

  EXPECT_THAT(report.determined, IsEmpty());
  EXPECT_EQ(report.blind.size(), 3u);
}

TEST(Observability, ZWithoutALedgeIsAbsorbedByTheDatum) {
  const std::vector<UnknownColumn> z = {{"placement.block.z"}, {"probe_pretravel.z"}};
  Eigen::MatrixXd top(2, 2);
  top << 1, -1, 1, -1;

  const ObservabilityReport report = Observe(top / kSigma_mm, z);

  ASSERT_EQ(report.blind.size(), 1u);
  EXPECT_EQ(report.blind[0].statement, "probe_pretravel.z - placement.block.z only");
  EXPECT_THAT(report.advice, Contains(HasSubstr("ledge")));
}

TEST(Observability, ZWithALedgeTellsPretravel) {
  const std::vector<UnknownColumn> z = {{"placement.block.z"}, {"probe_pretravel.z"}};
  Eigen::MatrixXd both(2, 2);
  both << 1, -1, -1, -1;

  EXPECT_THAT(Observe(both / kSigma_mm, z).blind, IsEmpty());
}

TEST(Observability, WhatNoRowTouchesIsNotToldAtAll) {
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 1, 0, 1, 0;

  const ObservabilityReport report =
      Observe(jacobian, std::vector<UnknownColumn>{{"backlash.x"}, {"backlash.y"}});

  ASSERT_EQ(report.blind.size(), 1u);
  EXPECT_EQ(report.blind[0].statement, "backlash.y not at all");
  EXPECT_NEAR(report.blind[0].blind_direction.at("backlash.y"), 1, 1e-12);
}

TEST(Observability, GroupsThatShareNothingAreToldApart) {
  const std::vector<UnknownColumn> two = {
      {"probe_pretravel.x"}, {"backlash.x"}, {"probe_pretravel.y"}, {"backlash.y"}};
  Eigen::MatrixXd jacobian(2, 4);
  jacobian << -2, -1, 0, 0, 0, 0, -2, -1;

  const ObservabilityReport report = Observe(jacobian / kSigma_mm, two);

  ASSERT_EQ(report.blind.size(), 2u);
  std::vector<std::string> statements;
  for (const Observability& blind : report.blind) statements.push_back(blind.statement);
  EXPECT_THAT(statements,
              UnorderedElementsAre("probe_pretravel.x + backlash.x / 2 only",
                                   "probe_pretravel.y + backlash.y / 2 only"));
}

TEST(Observability, ColumnsCountInMillimetres) {
  // The same span with backlash in micrometres: the words do not change.
  std::vector<UnknownColumn> columns = {{"probe_pretravel.x"},
                                        {.name = "backlash.x", .mm_per_unit = 1e-3}};
  Eigen::MatrixXd jacobian(1, 2);
  jacobian << -2, -1e-3;

  const ObservabilityReport report = Observe(jacobian / kSigma_mm, columns);

  ASSERT_EQ(report.blind.size(), 1u);
  EXPECT_EQ(report.blind[0].statement, "probe_pretravel.x + backlash.x / 2 only");
}

TEST(Observability, WeakestDirectionHasItsStandardDeviation) {
  // The release reads b to 1 um; the span tells 2 delta + b to 1 um, so delta to
  // about 0.7 um. Of [[2, 1], [0, 1]] the smallest singular value is known in closed
  // form: s^2 = 3 - sqrt(5).
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 2, 1, 0, 1;

  const ObservabilityReport report =
      Observe(jacobian / kSigma_mm,
              std::vector<UnknownColumn>{{"probe_pretravel.x"}, {"backlash.x"}});

  EXPECT_NEAR(report.weakest_sd_mm, kSigma_mm / std::sqrt(3 - std::sqrt(5)), 1e-9);
  EXPECT_THAT(report.weakest_statement, HasSubstr("backlash.x"));
  EXPECT_THAT(report.weakest_statement, HasSubstr("1.14 um"));
}

TEST(Observability, NoRowsTellNothing) {
  const ObservabilityReport report =
      Observe(Eigen::MatrixXd(0, 1), std::vector<UnknownColumn>{{"backlash.x"}});

  ASSERT_EQ(report.blind.size(), 1u);
  EXPECT_EQ(report.blind[0].statement, "backlash.x not at all");
}

TEST(Observability, NoiseBeyondAMillimetreHidesWhatAlgebraTells) {
  Eigen::MatrixXd jacobian(1, 1);
  jacobian << 0.5;  // 2 mm

  EXPECT_THAT(Observe(jacobian, std::vector<UnknownColumn>{{"backlash.x"}}).determined,
              IsEmpty());
}

TEST(CombinationInWords, WritesSimpleFractions) {
  const std::vector<std::string> names = {"a", "b", "c", "d"};

  EXPECT_EQ(CombinationInWords(names, Eigen::Vector4d(1, 0.5, -2, 0)),
            "a + b / 2 - 2 c");
  EXPECT_EQ(CombinationInWords(names, Eigen::Vector4d(-1, 2.0 / 3, 0, 0)), "2/3 b - a");
  EXPECT_EQ(CombinationInWords(names, Eigen::Vector4d(0, 0, -1, 0.0317)),
            "0.0317 d - c");
  EXPECT_EQ(CombinationInWords(names, Eigen::Vector4d(-1, 0, 0, 0)), "-a");
}

}  // namespace
}  // namespace caltwin
