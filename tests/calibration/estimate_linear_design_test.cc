// The linear design is what FitJoint does, and the best readings are the best ones.

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "calibration/estimate/linear_design.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

Machine Gantry() {
  Machine machine;
  for (AxisDrawing& axis : machine.axes)
    axis = {.min_mm = 0, .max_mm = 300, .lead_mm = 4};
  return machine;
}

// A laser reads x at places along it, come to in + or in -.
JointProblem Readings(const std::vector<double>& places_mm, double sigma_mm) {
  JointProblem problem{.machine = Gantry()};
  problem.free = {{.effect = EffectIndex<Backlash>(),
                   .axis = "x",
                   .prior = Given{.value = 0.05, .sd = 0.02}},
                  {.effect = EffectIndex<PitchProgressive>(),
                   .axis = "x",
                   .prior = Given{.value = 0, .sd = 50}}};
  for (const double place_mm : places_mm) {
    for (const double sense : {-1.0, 1.0}) {
      Observation reading{.sigma_mm = sigma_mm};
      reading.at = {.kind = RowKind::kPosition,
                    .q_mm = {place_mm, 0, 0},
                    .dir = {sense, 0, 0},
                    .n = {1, 0, 0}};
      reading.nuisances["placement.x"] = 1;
      problem.observations.push_back(reading);
    }
  }
  return problem;
}

TEST(LinearDesign, HasTheUncertaintyOfTheJointFit) {
  JointProblem problem = Readings({0, 100, 150, 300}, 0.001);
  const LinearDesign design = DesignOf(problem);
  const JointFit fit = FitJoint(problem);

  ASSERT_EQ(design.unknowns.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(design.unknowns[i].name, fit.estimates[i].name);
    EXPECT_NEAR(design.unknowns[i].sd / fit.estimates[i].sd, 1, 1e-6);
    EXPECT_EQ(design.unknowns[i].identifiable, fit.estimates[i].identifiable);
  }
}

// Its gain, row by row, is what a fit makes of one reading that is off by one sigma.
TEST(LinearDesign, PassesNoiseOnAsTheJointFitDoes) {
  JointProblem problem = Readings({0, 100, 150, 300}, 0.001);
  const LinearDesign design = DesignOf(problem);
  const JointFit before = FitJoint(problem);
  problem.observations[3].value_mm += 0.001;
  const JointFit after = FitJoint(problem);

  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double moved = after.estimates[at].value - before.estimates[at].value;
    EXPECT_NEAR(design.gain(i, 3), moved, 1e-6 * design.unknowns[at].sd);
  }
}

// Closed form: n readings each way tell the gap to sigma sqrt(2 / n), its belief of 20
// um hardly helping.
TEST(LinearDesign, OfAGapIsThatOfTwoMeans) {
  const LinearDesign design = DesignOf(Readings({50, 50, 50, 50, 50}, 0.001));

  EXPECT_NEAR(design.unknowns[0].sd, 0.001 * std::sqrt(2.0 / 5), 1e-6);
  EXPECT_FALSE(design.unknowns[1].identifiable);  // One place tells no bow.
  EXPECT_NEAR(design.unknowns[1].sd, 50, 0.01);
}

// A bow is told by the ends against the middle: what lies between is not missed.
TEST(EnoughReadings, OfABowAreItsEndsAndItsMiddle) {
  const JointProblem problem =
      Readings({0, 40, 80, 120, 150, 180, 220, 260, 300}, 0.001);
  std::set<double> places_mm;
  const EnoughReadings enough = EnoughOf(problem, 1.5);
  for (const std::size_t reading : enough.readings) {
    places_mm.insert(problem.observations[reading].at.q_mm[0]);
  }

  EXPECT_LT(enough.readings.size(), 12U);
  EXPECT_TRUE(places_mm.contains(0) && places_mm.contains(300));
  EXPECT_FALSE(places_mm.contains(80) && places_mm.contains(220));
  EXPECT_LE(enough.largest_ratio, 1.5 + 1e-6);
  EXPECT_EQ(enough.num_told, 2);
}

// What is left tells each quantity, not all of them on average: the design of these
// readings alone has no sd above the limit, and one reading fewer would have.
TEST(EnoughReadings, TellEveryQuantityWithinTheLimit) {
  constexpr double kMost = 1.1;
  JointProblem problem = Readings({0, 40, 80, 120, 150, 180, 220, 260, 300}, 0.001);
  const LinearDesign all = DesignOf(problem);
  const EnoughReadings enough = EnoughOf(problem, kMost);
  std::vector<Observation> left;
  for (const std::size_t reading : enough.readings) {
    left.push_back(problem.observations[reading]);
  }
  problem.observations = left;
  const LinearDesign design = DesignOf(problem);

  EXPECT_LT(enough.readings.size(), 18U);
  double largest = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    largest = std::max(largest, design.unknowns[i].sd / all.unknowns[i].sd);
  }
  EXPECT_LE(largest, kMost * (1 + 1e-6));
  EXPECT_NEAR(enough.largest_ratio, largest, 1e-6);
}

// A gap read at one place alone tells no bow; the bow's belief, which nothing improves,
// must not hide what is lost of the gap.
TEST(EnoughReadings, IgnoreWhatThePlanDoesNotTell) {
  const EnoughReadings enough =
      EnoughOf(Readings({50, 50, 50, 50, 50, 50, 50, 50}, 0.001), 1.05);

  EXPECT_EQ(enough.num_told, 1);
  EXPECT_EQ(enough.worst, "backlash.x");
  // sd = sigma sqrt(1 / n + 1 / m): of 8 and 8 one may go, sqrt((1/8 + 1/7) / (1/4)) =
  // 1.035, of 7 and 7 it would be 1.069.
  EXPECT_EQ(enough.readings.size(), 15U);
  EXPECT_NEAR(enough.largest_ratio, std::sqrt((1.0 / 8 + 1.0 / 7) * 4), 1e-3);
}

TEST(EnoughReadings, WithoutLossAreAll) {
  EXPECT_EQ(EnoughOf(Readings({0, 150, 300}, 0.001), 1).readings.size(), 6U);
}

// The gap is the least known of its belief: either sense is worth the same, and one
// more reading makes the sum of squares smaller than it was.
TEST(BestAfterAll, LeavesLessThanAllDid) {
  const JointProblem problem = Readings({0, 150, 300}, 0.001);

  for (const Optimal optimal : {Optimal::kA, Optimal::kD}) {
    EXPECT_LT(BestAfterAll(problem, optimal).relative_sd, RelativeSdOfAll(problem));
  }
}

}  // namespace
}  // namespace caltwin
