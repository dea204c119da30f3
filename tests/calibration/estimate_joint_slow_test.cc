#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "calibration/estimate/joint.h"
#include "tests/calibration/estimate_joint_rows.h"

namespace caltwin {
namespace {

using joint_test::Block;
using joint_test::Gap;
using joint_test::Hidden;
using joint_test::Latency;
using joint_test::Pretravel;
using joint_test::Problem;
using joint_test::Steps;
using joint_test::Tip;

constexpr int kRepeats = 400;
constexpr double kTipSd_mm = 0.0005;

// Errors of many repeated calibrations, in their own stated standard deviations: mean 0
// and standard deviation 1, with 95 % inside 1.96.
struct Coverage {
  double mean = 0;
  double variance = 0;
  double inside = 0;
};

Coverage Repeat(const std::string& name, double truth, Loss loss) {
  Coverage coverage;
  Rng rng(23, 0, "coverage");
  const Hidden hidden;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const double calliper_mm = hidden.radius_mm - 1 + kTipSd_mm * rng.Normal();
    JointProblem problem =
        Problem(Block(hidden, 3, true, &rng),
                {Steps(), Gap(), Pretravel(), Tip(calliper_mm, kTipSd_mm), Latency()});
    problem.loss = loss;
    const JointFit fit = FitJoint(problem);
    EXPECT_TRUE(fit.converged) << fit.message;
    const double z = (fit.Find(name)->value - truth) / fit.Find(name)->sd;
    coverage.mean += z / kRepeats;
    coverage.variance += z * z / kRepeats;
    if (std::abs(z) < 1.96) coverage.inside += 1.0 / kRepeats;
  }
  return coverage;
}

void ExpectHonest(const Coverage& coverage) {
  EXPECT_NEAR(coverage.mean, 0, 4 / std::sqrt(kRepeats));
  EXPECT_NEAR(coverage.variance, 1, 4 * std::sqrt(2.0 / kRepeats));
  EXPECT_NEAR(coverage.inside, 0.95, 4 * std::sqrt(0.95 * 0.05 / kRepeats));
}

TEST(JointCoverage, CovarianceOfBacklashIsTheScatterOfRepeats) {
  ExpectHonest(Repeat("backlash.x", Hidden{}.backlash_mm, Loss::kSquares));
}

TEST(JointCoverage, CovarianceOfPretravelIsTheScatterOfRepeats) {
  ExpectHonest(Repeat("probe_pretravel.x", Hidden{}.pretravel_mm, Loss::kSquares));
}

TEST(JointCoverage, CovarianceOfStepsIsTheScatterOfRepeats) {
  ExpectHonest(Repeat("steps_per_mm.x", Hidden{}.true_steps, Loss::kSquares));
}

TEST(JointCoverage, HubersCovarianceIsTheScatterOfRepeatsToo) {
  ExpectHonest(Repeat("backlash.x", Hidden{}.backlash_mm, Loss::kHuber));
}

}  // namespace
}  // namespace caltwin
