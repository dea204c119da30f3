// What the touches of a NeXT calibration tell, by differences of simulated
// calibrations: neither the estimators' formulas nor their derivatives, nor those of
// FisherOfTouches.

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenarios/runner.h"
#include "tests/scenarios/fisher_of_touches.h"

namespace caltwin {
namespace {

using F = FisherOfTouches;
constexpr double kSteps_per_mm = 800, kNominalGap_mm = 0.05,
                 kNominalPretravel_mm = 0.02;

// By how much each unknown is moved (scale, mm, s): every trigger by whole motor steps
// of 1.25 um, so that rounding does not show; but for the scale, by 0.4 % of a span.
constexpr std::array<double, F::kPlaces + 1> kMoved = {
    0.005, 0.02, 0.01, 0.01, 0.01, 0.01, 0.1};

// A calibration of x without noise, on a machine that differs by this from the nominal.
RunResult Calibrated(const std::array<double, F::kPlaces + 1>& off) {
  const std::string text = fmt::format(
      "machine: gantry_router\nfidelity: fast\n"
      "effects:\n"
      "  steps_per_mm.x: {{true_steps_per_mm: {}}}\n"
      "  backlash.x: {{gap_mm: {}}}\n"
      "  probe_pretravel.x: {{pretravel_mm: {}}}\n"
      "  tip_size: {{radius_error_mm: {}}}\n"
      "  trigger_latency: {{latency_ms: {}}}\n"
      "instruments: {{probe: {{sigma_um: 0}}}}\n"
      "artefacts: {{block: {{type: block123, at_mm: [{}, 150, 0], side: x}}}}\n"
      "calibrate: [{{next_all: {{variant: corrected, repeats: 10, axes: [x]}}}}]\n",
      kSteps_per_mm * (1 + off[F::kScale]),
      kNominalGap_mm + off[F::kGap],
      kNominalPretravel_mm + off[F::kPretravel],
      off[F::kTip],
      1e3 * off[F::kLatency],
      150 + off[F::kPlaces]);
  Scenario scenario =
      ReadScenarioText(text, CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml");
  scenario.machine.machine.probe.hysteresis_mm += off[F::kHysteresis];
  return RunScenario(scenario, {});
}

struct Touch {
  std::string campaign{}, setup{};
  double sense = 0;  ///< Of the face's normal along x.
  double motor_mm = 0;
};

// Where the motor stood at each trigger, in drawn mm: what it counts depends on the
// machine alone, not on the settings that the loop has changed since.
std::vector<Touch> TouchesOf(const RunResult& run) {
  std::vector<Touch> touches;
  for (const Row& row : run.rows.rows) {
    if (std::abs(row.n[0]) < 0.9) continue;
    const SettingsInForce& settings = run.header.settings.at(row.settings);
    double x_mm =
        row.cmd_mm[0] + row.n[0] * (row.value_mm + settings.tip_radius_mm.value());
    if (row.dir[0] < 0) x_mm -= settings.backlash_mm.at("x");
    touches.push_back(
        {.campaign = row.campaign,
         .setup = row.setup,
         .sense = row.n[0],
         .motor_mm = x_mm * settings.steps_per_mm.at("x") / kSteps_per_mm});
  }
  return touches;
}

class NextFisher : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    touches_ = TouchesOf(Calibrated({}));
    slopes_ = Eigen::MatrixXd(touches_.size(), kMoved.size());
    for (std::size_t k = 0; k < kMoved.size(); ++k) {
      std::array<double, F::kPlaces + 1> off{};
      off[k] = kMoved[k];
      const std::vector<Touch> moved = TouchesOf(Calibrated(off));
      ASSERT_EQ(moved.size(), touches_.size());
      for (std::size_t i = 0; i < moved.size(); ++i) {
        ASSERT_EQ(moved[i].setup, touches_[i].setup);
        slopes_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
            (moved[i].motor_mm - touches_[i].motor_mm) / kMoved[k];
      }
    }
  }

  // The first so many touches of a campaign; 0: all.
  static std::vector<std::size_t> Of(const std::string& campaign, std::size_t first) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      if (!campaign.empty() && touches_[i].campaign != campaign) continue;
      if (first == 0 || found.size() < first) found.push_back(i);
    }
    return found;
  }

  // Least standard deviations of all unknowns, each setup's place one of them.
  static Eigen::VectorXd Bounds(const std::vector<std::size_t>& touches) {
    std::set<std::string> setups;
    for (const std::size_t i : touches) setups.insert(touches_[i].setup);
    const Eigen::Index size = F::kPlaces + std::ssize(setups);
    // What a set of touches leaves open, gap or latency, is known to a metre or second.
    Eigen::MatrixXd information = Eigen::MatrixXd::Identity(size, size) * 1e-2;
    information(F::kTip, F::kTip) += 1 / std::pow(0.001, 2);
    information(F::kHysteresis, F::kHysteresis) += 1 / std::pow(0.0005, 2);
    const double variance_mm2 = 1e-6 + std::pow(1 / kSteps_per_mm, 2) / 12;
    for (const std::size_t i : touches) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
      const auto own = slopes_.row(static_cast<Eigen::Index>(i));
      row.head(F::kPlaces) = own.head(F::kPlaces);
      const auto setup = std::distance(setups.begin(), setups.find(touches_[i].setup));
      row[F::kPlaces + setup] = own[F::kPlaces];
      information += row * row.transpose() / variance_mm2;
    }
    return information.inverse().diagonal().cwiseSqrt();
  }

  static std::vector<Touch> touches_;
  static Eigen::MatrixXd slopes_;
};
std::vector<Touch> NextFisher::touches_{};
Eigen::MatrixXd NextFisher::slopes_{};

constexpr double kRoundedSpans = 0.01;  // 0.1 mm of 27.4, and of 78.2.

TEST_F(NextFisher, BoundsAreThoseOfFirstPrinciples) {
  F phase2, phases;
  AddPhase2(&phase2);
  AddPhases(&phases);
  AddKnown(&phase2);
  AddKnown(&phases);
  std::vector<std::size_t> touches = Of("dual_dimension.x", 40);
  const Eigen::VectorXd of_phase2 = Bounds(touches);
  for (const auto& more : {Of("trigger_release.x", 0), Of("deflection.x", 20)}) {
    touches.insert(touches.end(), more.begin(), more.end());
  }
  const Eigen::VectorXd of_phases = Bounds(touches);

  ASSERT_EQ(touches.size(), 140U);
  EXPECT_NEAR(of_phase2[F::kScale] / phase2.Bound(F::kScale), 1, kRoundedSpans);
  for (const int unknown : {+F::kScale, +F::kGap, +F::kPretravel}) {
    EXPECT_NEAR(of_phases[unknown] / phases.Bound(unknown), 1, kRoundedSpans)
        << unknown;
  }
}

// The procedure sets steps by phase 2. All it touches would tell them twice as well,
// and the joint estimate of those rows says so (docs/coverage.md).
TEST_F(NextFisher, AllTouchesTellStepsTwiceAsWellAsPhase2) {
  const double of_phase2 = Bounds(Of("dual_dimension.x", 40))[F::kScale];
  const double of_all = Bounds(Of("", 0))[F::kScale];
  Scenario scenario = ReadScenarioText(
      "machine: gantry_router\nfidelity: fast\n"
      "effects: {backlash.x: {gap_mm: 0.05}}\n"
      "instruments: {probe: {sigma_um: 1}}\n"
      "artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: x}}\n"
      "calibrate:\n"
      "  - next_all: {variant: corrected, repeats: 10, axes: [x]}\n"
      "  - joint_estimate: {axes: [x], measure: false, verify: false}\n",
      CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml");
  const RunResult joint = RunScenario(scenario, {});
  const auto steps =
      std::ranges::find(joint.parameters, "steps_per_mm.x", &ParameterResult::name);

  EXPECT_GT(of_phase2 / of_all, 2);
  ASSERT_NE(steps, joint.parameters.end());
  // Beside what a setting kept adds, which is nothing of the touches.
  const auto readings =
      std::ranges::find(steps->budget, "readings", &Contribution::input);
  ASSERT_NE(readings, steps->budget.end());
  EXPECT_NEAR(readings->u / (kSteps_per_mm * of_all), 1, kRoundedSpans);
}

}  // namespace
}  // namespace caltwin
