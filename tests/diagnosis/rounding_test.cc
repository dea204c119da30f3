#include "calibration/diagnosis/rounding.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/remains.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "tests/diagnosis/eighty_steps_delta.h"

namespace caltwin {
namespace {

constexpr double kStep_mm = 0.0125;

DataHeader Stated(double sigma_um) {
  DataHeader header;
  for (const char* tower : {"a", "b", "c"}) {
    header.settings["s1"].steps_per_mm[tower] = 1 / kStep_mm;
  }
  header.instruments["probe"] = {.kind = "probe", .sigma_um = sigma_um};
  return header;
}

Row Touch(double x_mm, double y_mm, double value_mm) {
  Row row{.kind = RowKind::kTouch, .setup = "bed", .settings = "s1"};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = value_mm;
  return row;
}

Observed Touched(const std::vector<Row>& rows, const DataHeader& header) {
  return {{.rows = rows}, header, EightyStepsDelta(), {}};
}

// Each carriage counts for a third there: three thirds of a step, by chance.
TEST(RoundingSigma, InTheMiddleIsASixthOfAStep) {
  const Observed observed = Touched({Touch(0, 0, 0)}, Stated(0));

  EXPECT_NEAR(RoundingSigma_mm(observed, 0), kStep_mm / 6, 1e-9);
}

// Nearly all of the height is that tower's: the bound of one step alone.
TEST(RoundingSigma, UnderATowerIsNearlyThatOfOneStep) {
  const Observed observed = Touched({Touch(0, 100, 0)}, Stated(0));
  const double one_step_mm = kStep_mm / std::sqrt(12.0);

  EXPECT_GT(RoundingSigma_mm(observed, 0), 0.8 * one_step_mm);
  EXPECT_LT(RoundingSigma_mm(observed, 0), one_step_mm);
}

// At a station, whose switch is touched again and again at one place.
Observed TouchedAtStation(const std::vector<double>& values_mm) {
  static const Machine kStation =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml");
  std::vector<Row> rows;
  for (const double value_mm : values_mm) {
    Row row{.row = static_cast<std::int64_t>(rows.size()) + 1,
            .campaign = "z_offset",
            .kind = RowKind::kTouch,
            .setup = "switch.nozzle"};
    row.cmd_mm = {120, 230, 1.5};
    row.n = {0, 0, 1};
    row.feature = "switch.nozzle";
    row.value_mm = value_mm;
    rows.push_back(row);
  }
  return {{.rows = rows}, {}, kStation, {}};
}

// A step of Z is 0.3125 um. 25 touches that count the same have its rounding in common,
// five times as much as would be left of each by itself; noise of a step parts them.
TEST(CountedSigma, OfTouchesThatCountTheSameDoesNotAverageOut) {
  constexpr int kTouches = 25;
  constexpr double kStepOfZ_mm = 0.0003125;
  const double one_mm = std::max(1e-4, kStepOfZ_mm / std::sqrt(12.0));
  Rng rng(1, 0, "touches");
  std::vector<double> noisy_mm;
  for (int i = 0; i < kTouches; ++i) {
    noisy_mm.push_back(std::round(rng.Normal()) * kStepOfZ_mm);
  }

  EXPECT_NEAR(
      CountedSigma_mm(TouchedAtStation(std::vector<double>(kTouches, 0)), "z_offset"),
      std::sqrt(kTouches) * one_mm,
      1e-9);
  EXPECT_NEAR(CountedSigma_mm(TouchedAtStation(noisy_mm), "z_offset"), one_mm, 1e-9);
}

TEST(RoundingSigma, IsNotAssumedWhereNobodyStatesSteps) {
  EXPECT_EQ(RoundingSigma_mm(Touched({Touch(0, 0, 0)}, {}), 0), 0);
}

TEST(RoundingSigma, IsPartOfWhatIsStated) {
  constexpr double kProbe_um = 3;
  const Observed observed = Touched({Touch(0, 0, 0)}, Stated(kProbe_um));

  EXPECT_NEAR(
      observed.StatedSigma_mm(0), std::hypot(MmFromUm(kProbe_um), kStep_mm / 6), 1e-9);
}

// Repeats that count the same steps are equal, and yet no truer than a step.
TEST(NoiseFloor, IsNotBelowWholeSteps) {
  std::vector<Row> rows;
  for (int i = 0; i < 24; ++i) {
    const int place = i / 2;
    const double turn = place;
    rows.push_back(Touch(60 * std::cos(turn), 60 * std::sin(turn), kStep_mm));
  }
  const Observed observed = Touched(rows, Stated(1));
  SearchResult search;
  search.richest.sigma_mm = {0.005};
  search.richest.dof = {10};

  const std::vector<Floor> floors = FloorsOf(observed, search);

  ASSERT_EQ(floors.size(), 1U);
  EXPECT_EQ(floors[0].dof, 12);  // Of the replicates, not of the richest model.
  EXPECT_GE(floors[0].sigma_mm, kStep_mm / 6);
  EXPECT_LE(floors[0].sigma_mm, kStep_mm / std::sqrt(12.0));
}

// A laser along an axis of 80 steps/mm whose controller stands at whole steps or, as a
// servo does, where it is told; 15 places, four times each.
Observed Axis80(bool at_steps, std::uint64_t seed) {
  constexpr double kSteps_per_mm = 80;
  constexpr int kPlaces = 15, kRuns = 4;
  Machine machine{.name = "test"};
  for (AxisDrawing& drawing : machine.axes) {
    drawing.lead_mm = 40;
    drawing.full_steps_per_rev = 200;
    drawing.microsteps = 16;
  }
  machine.settings.steps_per_mm = {kSteps_per_mm, kSteps_per_mm, kSteps_per_mm};
  DataHeader header;
  header.settings["1"].steps_per_mm["x"] = kSteps_per_mm;
  RowTable table;
  Rng rng(seed, 0, "whole steps");
  std::vector<double> places_mm;
  for (int i = 0; i < kPlaces; ++i) places_mm.push_back(300 * rng.Uniform());
  for (int i = 0; i < kPlaces * kRuns; ++i) {
    const double at_mm = places_mm[static_cast<std::size_t>(i % kPlaces)];
    Row row{.row = i + 1,
            .campaign = "laser",
            .kind = RowKind::kPosition,
            .settings = "1",
            .rep = i / kPlaces + 1};
    row.cmd_mm = {at_mm, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    const double stands_mm =
        at_steps ? std::round(at_mm * kSteps_per_mm) / kSteps_per_mm : at_mm;
    row.value_mm = stands_mm - at_mm + MmFromUm(rng.Normal());
    table.rows.push_back(row);
  }
  return {table, header, machine, {}};
}

TEST(RoundedBy, IsWhatTheNearestStepIsBeyondTheCommand) {
  const Observed observed = Axis80(true, 1);
  const double command_mm = observed.row(3).cmd_mm[0];

  EXPECT_NEAR(RoundedBy_mm(observed, 3, 0),
              std::round(command_mm / kStep_mm) * kStep_mm - command_mm,
              1e-9);
  EXPECT_EQ(RoundedBy_mm(observed, 3, 1), 0);  // Nothing is stated of it.
}

// Points of a circle stand at whole steps as targets do; what a machine file states
// holds where the header says nothing; where nobody states steps/mm, nothing is known.
TEST(RoundedBy, HoldsOnCirclesAndByTheMachineFile) {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {80, 80, 80};
  Row row{.row = 1, .campaign = "circle", .kind = RowKind::kRadial};
  row.cmd_mm = {10.003, 20, 0};
  row.n = {0.6, 0.8, 0};
  RowTable table;
  table.rows = {row, row};
  table.rows[1].row = 2;
  table.rows[1].kind = RowKind::kTouch;

  EXPECT_EQ(RoundedBy_mm({table, {}, machine, {}}, 0, 0), 0);
  machine.file = "machine.yaml";
  const Observed observed(table, {}, machine, {});
  EXPECT_NEAR(RoundedBy_mm(observed, 0, 0), 10 - 10.003, 1e-9);
  EXPECT_EQ(RoundedBy_mm(observed, 1, 0), 0);  // A touch ends where the surface is.
}

// Repeats share what a step leaves, so it is no noise: taken for noise, it would make
// the scale look twice as sure as it is.
TEST(RoundedBy, ScalesAreAsSureAsTheyAreSaidToBe) {
  constexpr int kMachines = 60;
  for (const bool at_steps : {false, true}) {
    double sum2 = 0;
    for (int seed = 1; seed <= kMachines; ++seed) {
      const Diagnosis diagnosis =
          Diagnose(Axis80(at_steps, static_cast<std::uint64_t>(seed)), {});
      const auto scale =
          std::ranges::find(diagnosis.baseline, "scale.x", &BaselineLine::name);
      ASSERT_NE(scale, diagnosis.baseline.end());
      EXPECT_LT(scale->sd, 3);  // ppm; by 3.6 um of steps it would be 10.
      sum2 += std::pow(scale->value / scale->sd, 2);
    }
    EXPECT_NEAR(std::sqrt(sum2 / kMachines), 1, 0.35) << "at steps: " << at_steps;
  }
}

}  // namespace
}  // namespace caltwin
