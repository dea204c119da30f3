// What RepRapFirmware and Klipper do not say of their settings: it is the scatter that
// they have over machines as they come.

#include <array>
#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "calibration/kinds/delta/engine_uncertainty.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {
namespace {

constexpr double kRadius_mm = 100, kSigma_mm = 0.01;
// Standard deviations a tenth of the priors: straight enough that squares of tilts and
// angles do not show.
constexpr double kPart = 0.1;

const DeltaModel<double> kDrawn = SymmetricDelta(300, 130, 250);
const std::vector<int> kSix = {kEndstopKnob,
                               kEndstopKnob + 1,
                               kEndstopKnob + 2,
                               kRadiusKnob,
                               kAngleKnob,
                               kAngleKnob + 1};

std::vector<DeltaTouch> Touched(SimulatedDelta* machine,
                                const DeltaModel<double>& settings) {
  std::vector<DeltaTouch> touches;
  for (const Eigen::Vector2d& at : RrfProbePoints(kRadius_mm)) {
    touches.push_back(
        {.motors_mm = *machine->Touch(settings, at[0], at[1]), .sigma_mm = kSigma_mm});
  }
  return touches;
}

std::array<double, 6> NumbersOf(const DeltaModel<double>& model) {
  return {model.endstop_mm[0],
          model.endstop_mm[1],
          model.endstop_mm[2],
          model.radius_mm[2],
          DegFromRad(model.angle_rad[0]),
          DegFromRad(model.angle_rad[1])};
}

// Squares of what six factors err by on machines of which these knobs are drawn.
std::array<double, 6> MeanSquares(const std::vector<int>& drawn, int machines) {
  std::array<double, 6> squares{};
  Rng rng(7, 0, "engine.machines");
  for (int i = 0; i < machines; ++i) {
    DeltaBuild<double> build{.model = kDrawn};
    DeltaBed<double> bed;
    for (const int knob : drawn) {
      const DeltaKnob& is = kDeltaKnobs[static_cast<std::size_t>(knob)];
      TurnKnob(knob, kPart * is.prior_sd * is.per_unit * rng.Normal(), &build, &bed);
    }
    SimulatedDelta machine(build, bed, kSigma_mm, static_cast<std::uint64_t>(i));
    const DeltaOutcome outcome = FitRrf(Touched(&machine, kDrawn), kDrawn, 6);
    const auto found = NumbersOf(outcome.settings), built = NumbersOf(build.model);
    for (std::size_t k = 0; k < found.size(); ++k) {
      squares[k] += std::pow(found[k] - built[k], 2) / machines;
    }
  }
  return squares;
}

EngineUncertainty Stated() {
  SimulatedDelta machine({.model = kDrawn}, {}, 0, 1);
  return UncertaintyOfHeightSquares(kDrawn,
                                    {.procedure = "rrf_least_squares",
                                     .knobs = kSix,
                                     .touches = Touched(&machine, kDrawn)});
}

double ShareOf(const Estimate& estimate, const std::string& input) {
  for (const Contribution& one : estimate.budget) {
    if (one.input == input) return one.u;
  }
  return 0;
}

// Machines that the engine's model has: what is left is the touches' noise.
TEST(EngineUncertainty, OfAMachineThatItsModelHasIsTheTouches) {
  constexpr int kMachines = 400;
  const auto squares = MeanSquares({kRadiusKnob, kAngleKnob}, kMachines);
  const EngineUncertainty stated = Stated();

  ASSERT_EQ(stated.estimates.size(), 6U);
  for (std::size_t k = 0; k < 6; ++k) {
    const Estimate& one = stated.estimates[k];
    // An rms of 400 is known to 3.5 %: five of these.
    EXPECT_NEAR(std::sqrt(squares[k]) / ShareOf(one, "touches"), 1, 0.18) << one.name;
  }
}

// Unlike rods and a tilted bed, which six factors do not have, bend all six.
TEST(EngineUncertainty, CountsWhatTheModelHasNot) {
  constexpr int kMachines = 400;
  const auto squares = MeanSquares({kRodKnob,
                                    kRodKnob + 1,
                                    kRodKnob + 2,
                                    kRodKnob + 3,
                                    kRodKnob + 4,
                                    kRodKnob + 5,
                                    kBedKnob,
                                    kBedKnob + 1},
                                   kMachines);
  for (const auto stated = Stated(); const Estimate& one : stated.estimates) {
    const auto k = static_cast<std::size_t>(&one - stated.estimates.data());
    const double of_model = std::hypot(ShareOf(one, "rod_mismatch, not in its model"),
                                       ShareOf(one, "bed_tilt, not in its model"));
    const double u = std::hypot(ShareOf(one, "touches"), kPart * of_model);
    EXPECT_NEAR(std::sqrt(squares[k]) / u, 1, 0.18) << one.name;
  }
}

// A carriage is twisted with its tower's angle, which the engine moves alone.
TEST(EngineUncertainty, CountsTheTwistThatGoesWithAnAngle) {
  DeltaBuild<double> drawn{.model = kDrawn};
  SimulatedDelta machine(drawn, {}, 0, 1);
  const auto of_twist = [&](double twist_per_angle) {
    drawn.twist_per_angle = twist_per_angle;
    const EngineUncertainty told = UncertaintyOfHeightSquares(
        kDrawn, {.knobs = kSix, .touches = Touched(&machine, kDrawn), .drawn = drawn});
    return ShareOf(told.estimates[0], "tower_twist, not in its model");
  };
  // Priors of 0.5 deg, and of 2 deg for two towers' angles: c strays by its twist
  // alone.
  EXPECT_GT(of_twist(0.8), of_twist(0));
  EXPECT_LT(of_twist(0.8), std::hypot(0.5, 2) / 0.5 * of_twist(0));
}

TEST(EngineUncertainty, CorrelatesWhatATiltMovesTogether) {
  const EngineUncertainty stated = Stated();

  ASSERT_EQ(stated.correlations.size(), 1U);
  const Correlations& of = stated.correlations[0];
  EXPECT_EQ(of.names.size(), 6U);
  // A tilt raises one endstop as it lowers another.
  EXPECT_LT(of.matrix(0, 1), -0.3);
  EXPECT_TRUE(of.matrix.isApprox(of.matrix.transpose()));
}

TEST(EngineUncertainty, OfTooFewPlacesThereIsNone) {
  SimulatedDelta machine({.model = kDrawn}, {}, 0, 1);
  std::vector<DeltaTouch> touches = Touched(&machine, kDrawn);
  touches.resize(5);

  EXPECT_TRUE(UncertaintyOfHeightSquares(kDrawn, {.knobs = kSix, .touches = touches})
                  .estimates.empty());
}

}  // namespace
}  // namespace caltwin
