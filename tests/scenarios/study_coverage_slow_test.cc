// The intervals that the NeXT calibration states hold the truth as often as they say,
// and its estimates scatter hardly more than the Cramer-Rao bound of its touches.

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <unistd.h>

#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMachines = 600;
constexpr double kOneInSoMany = 1e-5;  // That an honest estimator fails here.

const fs::path kStudies = fs::path(CALTWIN_SOURCE_DIR) / "scenarios/studies";

StudySummary SummaryOfSome(const fs::path& file, std::int64_t machines) {
  Study study = ReadStudy(file);
  study.trials = machines;
  const fs::path folder =
      fs::path(::testing::TempDir()) / ("study_coverage" + std::to_string(getpid()));
  fs::remove_all(folder);
  StudyStore store(folder, study, /*may_resume=*/false);
  RunStudy(study, {.workers = 2}, &store);
  return SummaryOf(study, store);
}

// P(hits <= k) of a binomial distribution.
double BinomialLowerTail(std::int64_t k, std::int64_t n, double p) {
  double tail = 0;
  for (std::int64_t i = 0; i <= k; ++i) {
    const auto hits = static_cast<double>(i);
    const auto misses = static_cast<double>(n - i);
    tail += std::exp(std::lgamma(static_cast<double>(n) + 1) - std::lgamma(hits + 1) -
                     std::lgamma(misses + 1) + hits * std::log(p) +
                     misses * std::log1p(-p));
  }
  return tail;
}

// Fisher information of phases 2 to 4 on one axis, from the touches alone: unknowns are
// steps (as scale error), gap, pre-travel, tip, hysteresis, latency and the places of
// the block as it is laid. First principles, not the estimators' formulas.
class Fisher {
 public:
  enum Unknown { kScale, kGap, kPretravel, kTip, kHysteresis, kLatency, kPlaces };
  static constexpr int kNumUnknowns = kPlaces + 3;

  void AddTouches(int count, int place, double sense, double size_mm, double v_mm_s) {
    Eigen::VectorXd row = Row(place, sense, size_mm);
    row[kGap] = -0.5;
    row[kLatency] = -v_mm_s;
    Add(row, count);
  }
  void AddReleases(int count, int place, double sense, double size_mm, double v_mm_s) {
    Eigen::VectorXd row = Row(place, sense, size_mm);
    row[kGap] = 0.5;
    row[kLatency] = v_mm_s;
    row[kHysteresis] = 1;
    Add(row, count);
  }
  void AddKnown(int unknown, double sd) {
    information_(unknown, unknown) += 1 / (sd * sd);
  }

  double Bound(int unknown) const {
    const Eigen::MatrixXd covariance = information_.ldlt().solve(
        Eigen::MatrixXd::Identity(kNumUnknowns, kNumUnknowns));
    return std::sqrt(covariance(unknown, unknown));
  }

 private:
  static Eigen::VectorXd Row(int place, double sense, double size_mm) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kNumUnknowns);
    row[kScale] = -size_mm / 2;  // Faces `size` apart, each moving by half.
    row[kPretravel] = -1;
    row[kTip] = 1;
    row[kPlaces + place] = sense;
    return row;
  }
  void Add(const Eigen::VectorXd& row, int count) {
    constexpr double kSigma_mm = 0.001, kStep_mm = 0.00125;
    const double variance_mm2 = kSigma_mm * kSigma_mm + kStep_mm * kStep_mm / 12;
    information_ += count / variance_mm2 * row * row.transpose();
  }

  Eigen::MatrixXd information_ = Eigen::MatrixXd::Zero(kNumUnknowns, kNumUnknowns);
};

constexpr int kRepeats = 10;
constexpr double kSmall_mm = 27.4, kLarge_mm = 78.2;  // With the ball's diameter.

// Phase 2, of which steps/mm are made. Those of the verifications are kept apart, and
// later phases find the steps set: all touches together would tell them better.
void AddPhase2(Fisher* fisher) {
  for (const double sense : {-1.0, 1.0}) {
    fisher->AddTouches(kRepeats, 0, sense, kSmall_mm, 1);
    fisher->AddTouches(kRepeats, 1, sense, kLarge_mm, 1);
  }
}

// Phases 2 to 4, of which backlash and pre-travel are made.
void AddPhases(Fisher* fisher) {
  AddPhase2(fisher);
  for (const double sense : {-1.0, 1.0}) {
    for (const double v_mm_s : {1.0, 5.0}) {
      fisher->AddTouches(kRepeats, 2, sense, kLarge_mm, v_mm_s);
      fisher->AddReleases(kRepeats, 2, sense, kLarge_mm, v_mm_s);
    }
    fisher->AddTouches(kRepeats, 0, sense, kSmall_mm, 1);
  }
}

void AddKnown(Fisher* fisher) {
  fisher->AddKnown(Fisher::kTip, 0.001);
  fisher->AddKnown(Fisher::kHysteresis, 0.0005);
  // Not told, and not needed, by one feed and no release.
  for (const int unknown : {+Fisher::kGap, +Fisher::kLatency, Fisher::kPlaces + 2}) {
    fisher->AddKnown(unknown, 1);
  }
}

// How many quantities state an uncertainty; each must hold the truth as often as it
// says.
int ExpectHonest(const CaseSummary& summary) {
  int estimators = 0;
  for (const ParameterSummary& one : summary.parameters) {
    const std::int64_t hits = one.coverage95.hits, of = one.coverage95.cases;
    if (of == 0) continue;
    ++estimators;
    EXPECT_GT(BinomialLowerTail(hits, of, 0.95), kOneInSoMany / 2)
        << summary.name << " " << one.name << " " << hits << " of " << of;
    EXPECT_GT(BinomialLowerTail(of - hits, of, 0.05), kOneInSoMany / 2)
        << summary.name << " " << one.name << " " << hits << " of " << of;
  }
  return estimators;
}

class NextCoverage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    summary_ = new StudySummary(SummaryOfSome(kStudies / "next.yaml", kMachines));
  }
  static void TearDownTestSuite() { delete summary_; }

  static const ParameterSummary& Of(const std::string& name) {
    for (const ParameterSummary& one : summary_->cases.at(0).parameters) {
      if (one.name == name) return one;
    }
    throw std::logic_error(name);
  }
  static const StudySummary& summary() { return *summary_; }

 private:
  static StudySummary* summary_;
};
StudySummary* NextCoverage::summary_ = nullptr;

TEST_F(NextCoverage, IntervalsOf95PercentHoldThatOften) {
  const CaseSummary& next = summary().cases.at(0);
  for (const ParameterSummary& one : next.parameters) {
    if (one.coverage95.cases == 0) continue;
    EXPECT_GE(one.coverage95.cases, kMachines * 99 / 100) << one.name;
  }
  EXPECT_EQ(ExpectHonest(next), 11);
}

TEST_F(NextCoverage, ScatterIsTheCramerRaoBound) {
  Fisher phase2, phases;
  AddPhase2(&phase2);
  AddPhases(&phases);
  AddKnown(&phase2);
  AddKnown(&phases);
  // A standard deviation of 600 is known to 2.9 %, five times that are allowed beyond
  // the 10 % that estimators may lose, none below the bound.
  const double chance = 5 / std::sqrt(2.0 * kMachines);
  for (const std::string axis : {"x", "y"}) {
    const std::map<std::string, double> bounds = {
        {"steps_per_mm." + axis, 800 * phase2.Bound(Fisher::kScale)},
        {"backlash." + axis, phases.Bound(Fisher::kGap)},
        {"probe_pretravel." + axis, phases.Bound(Fisher::kPretravel)}};
    for (const auto& [name, bound] : bounds) {
      const double ratio = Of(name).error.sd / bound;
      RecordProperty(name, std::to_string(ratio));
      EXPECT_GT(ratio, 1 - chance) << name;
      EXPECT_LT(ratio, 1.1 + chance) << name;
    }
  }
}

class EveryCoverage : public ::testing::TestWithParam<std::string> {};

// The studies whose tables stand in docs/coverage.md, with fewer machines.
TEST_P(EveryCoverage, IntervalsOf95PercentHoldThatOften) {
  constexpr std::int64_t kFew = 200;
  const StudySummary summary =
      SummaryOfSome(kStudies / "coverage" / (GetParam() + ".yaml"), kFew);

  for (const CaseSummary& one : summary.cases) {
    EXPECT_GT(ExpectHonest(one), 0) << one.name;
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryCoverage,
                         ::testing::Values("gantry",
                                           "deflection",
                                           "joint",
                                           "joint_squareness",
                                           "delta",
                                           "triple_z",
                                           "motor_home",
                                           "motor_sync",
                                           "station",
                                           "feeler"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace caltwin
