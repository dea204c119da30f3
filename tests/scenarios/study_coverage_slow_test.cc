// The intervals that procedures state hold the truth as often as they say, and their
// estimates scatter hardly more than the Cramer-Rao bound of their touches.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "calibration/estimate/correlation.h"
#include "scenarios/result.h"
#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"
#include "tests/scenarios/kept_bounds.h"

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

// How often it holds the truth, by chance both ways.
void ExpectCovered(const std::string& name, const Rate& held) {
  const std::int64_t hits = held.hits, of = held.cases;
  EXPECT_GT(BinomialLowerTail(hits, of, 0.95), kOneInSoMany / 2)
      << name << " " << hits << " of " << of;
  EXPECT_GT(BinomialLowerTail(of - hits, of, 0.05), kOneInSoMany / 2)
      << name << " " << hits << " of " << of;
}

// A standard deviation of n is known to 1 / sqrt(2 n): five times that are allowed
// beyond the 10 % that estimators may lose, none below the bound.
void ExpectAtTheBound(const std::string& name, double scatter, double bound, double n) {
  const double chance = 5 / std::sqrt(2 * n);
  EXPECT_GT(scatter / bound, 1 - chance) << name;
  EXPECT_LT(scatter / bound, 1.1 + chance) << name;
}

// Of 200 intervals that are far too wide all hold, as of honest ones they may: so the
// scatter is compared with the stated u too, to five times what chance leaves of it.
// The 15 % are what 93 to 97 % leave, and what a sd told by 24 readings is off.
void ExpectScatterAsStated(const std::string& name, const ParameterSummary& one) {
  constexpr double kNormal95 = 1.96, kMayDiffer = 0.15;
  const double chance = 5 / std::sqrt(2 * static_cast<double>(one.coverage95.cases));
  const double of_u = one.rms_over_sd * one.stated.k / kNormal95;
  EXPECT_NEAR(of_u, 1, kMayDiffer + chance) << name;
}

// Which quantities state an uncertainty; each must hold the truth as often as it says,
// and scatter as its touches' bound has it where there is one.
std::vector<std::string> ExpectHonest(const CaseSummary& summary) {
  static const std::map<std::string, double> bounds = KeptBounds();
  std::vector<std::string> estimators;
  for (const ParameterSummary& one : summary.parameters) {
    if (one.coverage95.cases == 0) continue;
    const std::string name = summary.name + " " + one.name;
    estimators.push_back(name);
    ExpectCovered(name, one.coverage95);
    ExpectScatterAsStated(name, one);
    if (const auto bound = bounds.find(name); bound != bounds.end()) {
      ExpectAtTheBound(
          name, one.error.sd, bound->second, static_cast<double>(one.coverage95.cases));
    }
  }
  return estimators;
}

TEST(NextCoverage, IntervalsHoldAndScatterIsTheBound) {
  const CaseSummary next = SummaryOfSome(kStudies / "next.yaml", kMachines).cases.at(0);
  for (const ParameterSummary& one : next.parameters) {
    if (one.coverage95.cases == 0) continue;
    EXPECT_GE(one.coverage95.cases, kMachines * 99 / 100) << one.name;
  }
  EXPECT_EQ(ExpectHonest(next).size(), 11);
}

// What one run says of how its results go together, by the inputs that they share, is
// how the errors of many machines do: to five times what chance leaves.
TEST(NextCoverage, ResultsGoTogetherAsARunSays) {
  const Study study = ReadStudy(kStudies / "next.yaml");
  const std::vector<Correlations> said = AllCorrelations(RunTrial(study, 0, 0));
  const Correlations errors =
      SummaryOfSome(kStudies / "next.yaml", kMachines).cases.at(0).correlations;
  const auto at = [](const Correlations& of, const std::string& name) {
    return std::ranges::find(of.names, name) - of.names.begin();
  };

  ASSERT_FALSE(said.empty());
  const Correlations& shared = said.back();
  int num_large = 0;
  for (const std::string& a : shared.names) {
    for (const std::string& b : shared.names) {
      if (a >= b) continue;
      const double stated = shared.matrix(at(shared, a), at(shared, b));
      const double found = errors.matrix(at(errors, a), at(errors, b));
      const double chance = 5 * (1 - stated * stated) / std::sqrt(double{kMachines});
      EXPECT_NEAR(found, stated, chance + 0.05) << a << " with " << b;
      num_large += std::abs(stated) > 0.4 ? 1 : 0;
    }
  }
  EXPECT_EQ(num_large, 6);  // Three pre-travels by the ball, three gaps by the switch.
}

// A study of scenarios/studies/coverage, and each estimator of it that states an
// uncertainty, as "contender quantity": one that is told no more, or states none any
// longer, is a failure and not a shorter table.
struct CoverageStudy {
  std::string file;
  std::vector<std::string> estimators;
};

std::string FileOf(const ::testing::TestParamInfo<CoverageStudy>& study) {
  return study.param.file;
}

class EveryCoverage : public ::testing::TestWithParam<CoverageStudy> {};

// The studies whose tables stand in docs/coverage.md, with fewer machines.
TEST_P(EveryCoverage, IntervalsOf95PercentHoldThatOften) {
  constexpr std::int64_t kFew = 200;
  const StudySummary summary =
      SummaryOfSome(kStudies / "coverage" / (GetParam().file + ".yaml"), kFew);

  std::vector<std::string> found;
  for (const CaseSummary& one : summary.cases) {
    const std::vector<std::string> told = ExpectHonest(one);
    found.insert(found.end(), told.begin(), told.end());
    for (const ParameterSummary& parameter : one.parameters) {
      if (parameter.coverage95.cases == 0) continue;
      EXPECT_GE(parameter.coverage95.cases, kFew / 2) << parameter.name;
    }
  }
  EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(GetParam().estimators));
}

std::vector<CoverageStudy> StudiesOfGantries() {
  return {{"gantry",
           {"next_rough_steps_recovers steps_per_mm.x",
            "next_dual_dimension_corrected steps_per_mm.x",
            "next_cluster_backlash_corrected backlash.x",
            "trigger_release_with_compensation_corrected backlash.x",
            "dial_backlash backlash.y",
            "bed_tilt_of_a_plate bed_tilt.slope_x_mrad",
            "bed_tilt_of_a_plate bed_tilt.slope_y_mrad"}},
          {"deflection",
           {"next_deflection_corrected probe_pretravel.x",
            "next_deflection_in_a_pocket backlash.y",
            "next_deflection_in_a_pocket probe_pretravel.y"}},
          {"block_sizes",
           {"dual_dimension_by_a_certified_block steps_per_mm.x",
            "deflection_by_a_certified_block probe_pretravel.x"}},
          {"joint",
           {"joint_estimate_on_a_tilted_ledge: joint_estimate steps_per_mm.z",
            "joint_estimate_on_a_tilted_ledge: joint_estimate backlash.z",
            "joint_estimate_on_a_tilted_ledge: joint_estimate probe_pretravel.z",
            "joint_estimate_on_a_tilted_ledge: joint_estimate tip_size",
            "joint_estimate_on_a_tilted_ledge: joint_estimate trigger_latency",
            "joint_estimate_on_a_tilted_ledge: joint_estimate bed_tilt.slope_x_mrad",
            "joint_estimate_on_a_tilted_ledge: joint_estimate bed_tilt.slope_y_mrad"}},
          {"joint_squareness",
           {"squareness_by_joint_estimate: joint_estimate steps_per_mm.x",
            "squareness_by_joint_estimate: joint_estimate steps_per_mm.y",
            "squareness_by_joint_estimate: joint_estimate backlash.x",
            "squareness_by_joint_estimate: joint_estimate backlash.y",
            "squareness_by_joint_estimate: joint_estimate squareness.C0Y",
            "squareness_by_joint_estimate: joint_estimate probe_pretravel.x",
            "squareness_by_joint_estimate: joint_estimate probe_pretravel.y",
            "squareness_by_joint_estimate: joint_estimate tip_size",
            "squareness_by_joint_estimate: joint_estimate trigger_latency",
            "squareness_by_joint_estimate: joint_estimate bed_tilt.slope_x_mrad",
            "squareness_by_joint_estimate: joint_estimate bed_tilt.slope_y_mrad"}}};
}

std::vector<CoverageStudy> StudiesOfDeltas() {
  return {{"delta",
           {"delta_joint_recovers endstop.a",
            "delta_joint_recovers endstop.b",
            "delta_joint_recovers endstop.c",
            "delta_joint_recovers delta_radius",
            "delta_joint_recovers tower_angle.a",
            "delta_joint_recovers tower_angle.b",
            "delta_joint_recovers bed_tilt.slope_x_mrad",
            "delta_joint_recovers bed_tilt.slope_y_mrad"}},
          {"delta_engines",
           {"delta_rrf_six_factors endstop.a",
            "delta_rrf_six_factors endstop.b",
            "delta_rrf_six_factors endstop.c",
            "delta_rrf_six_factors delta_radius",
            "delta_rrf_six_factors tower_angle.a",
            "delta_rrf_six_factors tower_angle.b",
            "delta_klipper_seven_touches endstop.a",
            "delta_klipper_seven_touches endstop.b",
            "delta_klipper_seven_touches endstop.c",
            "delta_klipper_seven_touches delta_radius",
            "delta_klipper_seven_touches tower_angle.a",
            "delta_klipper_seven_touches tower_angle.b"}},
          {"delta_rods",
           {"delta_rods_by_calliper endstop.a",
            "delta_rods_by_calliper endstop.b",
            "delta_rods_by_calliper endstop.c",
            "delta_rods_by_calliper tower_angle.a",
            "delta_rods_by_calliper tower_angle.b",
            "delta_rods_by_calliper arm_length",
            "delta_rods_by_calliper rod_mismatch.a1",
            "delta_rods_by_calliper rod_mismatch.a2",
            "delta_rods_by_calliper rod_mismatch.b1",
            "delta_rods_by_calliper rod_mismatch.b2",
            "delta_rods_by_calliper rod_mismatch.c1",
            "delta_rods_by_calliper rod_mismatch.c2",
            "delta_rods_by_calliper tower_lean.a.radial_mrad",
            "delta_rods_by_calliper tower_lean.b.radial_mrad",
            "delta_rods_by_calliper tower_lean.c.radial_mrad",
            "delta_rods_by_calliper tower_lean.a.tangential_mrad",
            "delta_rods_by_calliper tower_lean.b.tangential_mrad",
            "delta_rods_by_calliper tower_lean.c.tangential_mrad",
            "delta_rods_by_calliper tower_twist.a",
            "delta_rods_by_calliper tower_twist.b",
            "delta_rods_by_calliper tower_twist.c",
            "delta_rods_by_calliper bed_tilt.slope_x_mrad",
            "delta_rods_by_calliper bed_tilt.slope_y_mrad"}}};
}

std::vector<CoverageStudy> MoreStudiesOfDeltas() {
  return {{"delta_factors", {"delta_rrf_3 endstop.a",     "delta_rrf_3 endstop.b",
                             "delta_rrf_3 endstop.c",     "delta_rrf_4 endstop.a",
                             "delta_rrf_4 endstop.b",     "delta_rrf_4 endstop.c",
                             "delta_rrf_4 delta_radius",  "delta_rrf_7 endstop.a",
                             "delta_rrf_7 endstop.b",     "delta_rrf_7 endstop.c",
                             "delta_rrf_7 delta_radius",  "delta_rrf_7 tower_angle.a",
                             "delta_rrf_7 tower_angle.b", "delta_rrf_7 arm_length",
                             "delta_rrf_8 endstop.a",     "delta_rrf_8 endstop.b",
                             "delta_rrf_8 endstop.c",     "delta_rrf_8 delta_radius",
                             "delta_rrf_8 tower_angle.a", "delta_rrf_8 tower_angle.b",
                             "delta_rrf_9 endstop.a",     "delta_rrf_9 endstop.b",
                             "delta_rrf_9 endstop.c",     "delta_rrf_9 delta_radius",
                             "delta_rrf_9 tower_angle.a", "delta_rrf_9 tower_angle.b",
                             "delta_rrf_9 arm_length"}},
          {"delta_print",
           {"delta_print endstop.a",
            "delta_print endstop.b",
            "delta_print endstop.c",
            "delta_print tower_angle.a",
            "delta_print tower_angle.b",
            "delta_print arm_length",
            "delta_print rod_mismatch.a1",
            "delta_print rod_mismatch.a2",
            "delta_print rod_mismatch.b1",
            "delta_print rod_mismatch.b2",
            "delta_print rod_mismatch.c1",
            "delta_print rod_mismatch.c2",
            "delta_print tower_lean.a.radial_mrad",
            "delta_print tower_lean.b.radial_mrad",
            "delta_print tower_lean.c.radial_mrad",
            "delta_print tower_lean.a.tangential_mrad",
            "delta_print tower_lean.b.tangential_mrad",
            "delta_print tower_lean.c.tangential_mrad",
            "delta_print tower_twist.a",
            "delta_print tower_twist.b",
            "delta_print tower_twist.c",
            "delta_print bed_tilt.slope_x_mrad",
            "delta_print bed_tilt.slope_y_mrad"}}};
}

std::vector<CoverageStudy> StudiesOfOthers() {
  return {{"triple_z",
           {"tz_levels_in_one_round bed_tilt.slope_x_mrad",
            "tz_levels_in_one_round bed_tilt.slope_y_mrad",
            "tz_pivots_and_wiring pivot_position.z3.dx_mm",
            "tz_pivots_and_wiring pivot_position.z3.dy_mm",
            "tz_pivots_and_wiring pivot_position.z2.dx_mm",
            "tz_pivots_and_wiring pivot_position.z2.dy_mm",
            "tz_pivots_and_wiring pivot_position.z1.dx_mm",
            "tz_pivots_and_wiring pivot_position.z1.dy_mm",
            "tz_pivots_and_wiring bed_tilt.slope_x_mrad",
            "tz_pivots_and_wiring bed_tilt.slope_y_mrad"}},
          {"pivots_from_rounds",
           {"tz_pivots_from_two_rounds pivot_position.z3.dx_mm",
            "tz_pivots_from_two_rounds pivot_position.z3.dy_mm",
            "tz_pivots_from_two_rounds pivot_position.z2.dx_mm",
            "tz_pivots_from_two_rounds pivot_position.z2.dy_mm",
            "tz_pivots_from_two_rounds pivot_position.z1.dx_mm",
            "tz_pivots_from_two_rounds pivot_position.z1.dy_mm"}},
          {"motor_backlash",
           {"motor_backlash_opposite_approaches backlash.x",
            "motor_backlash_opposite_approaches home_offset.x",
            "motor_backlash_opposite_approaches backlash.a",
            "motor_backlash_opposite_approaches home_offset.a"}},
          {"motor_home",
           {"motor_servo_home home_offset.x",
            "motor_rotary_home home_offset.a",
            "motor_travel_limits home_offset.x",
            "motor_travel_limits travel.x",
            "motor_travel_limits home_offset.u",
            "motor_travel_limits travel.u"}},
          {"motor_sync",
           {"motor_axis_sync start_lead.x",
            "motor_axis_sync start_lead.y",
            "motor_axis_sync start_lead.z"}},
          {"station", {"z_offset_worn_switch endstop_scatter"}},
          {"feeler", {"z_offset_wrong_switch_offset_found switch_offset"}}};
}

std::vector<CoverageStudy> CoverageStudies() {
  std::vector<CoverageStudy> all = StudiesOfGantries();
  for (const auto& more :
       {StudiesOfDeltas(), MoreStudiesOfDeltas(), StudiesOfOthers()}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryCoverage,
                         ::testing::ValuesIn(CoverageStudies()),
                         FileOf);

}  // namespace
}  // namespace caltwin
