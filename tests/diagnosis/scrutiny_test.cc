// What the scrutiny of names makes of a jump that may be gradual.
#include "calibration/diagnosis/scrutiny.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/diagnosis/own_shape.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr Eigen::Index kScrutinyRows = 90;
constexpr double kScrutinySigma_mm = 1e-3;

Machine MachineOfScrutiny() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// One place along x, read each half minute; what is read rises by `height_um` within
// `over` rows.
Observed RiseWithin(double over, double height_um) {
  Rng rng(11, 0, "scrutiny_test");
  RowTable table;
  for (Eigen::Index i = 0; i < kScrutinyRows; ++i) {
    Row row{.row = i + 1, .campaign = "datum"};
    row.t_s = 30 * static_cast<double>(i);
    row.cmd_mm = {50, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    const double share =
        std::clamp((static_cast<double>(i) - 44.5) / over + 0.5, 0., 1.);
    row.value_mm = 1e-3 * height_um * share + kScrutinySigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return {table, {}, MachineOfScrutiny(), {}};
}

std::size_t IndexOf(const std::vector<Candidate>& candidates, const std::string& name) {
  return static_cast<std::size_t>(
      std::ranges::find(candidates, name, &Candidate::Name) - candidates.begin());
}

// A search that found lost steps of x alone, beside an offset.
SearchResult OnlyLostSteps(const Observed& observed,
                           const std::vector<Candidate>& candidates) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kScrutinyRows);
  SearchResult search;
  search.circumstances = {
      .sigma_mm = ones * kScrutinySigma_mm,
      .nuisances = {{.name = "offset", .unit = "mm", .column_mm = ones, .prior_sd = 1}},
      .left_out = std::vector<bool>(static_cast<std::size_t>(kScrutinyRows), false)};
  const std::size_t jump = IndexOf(candidates, "missed_steps.x");
  const Weighed weighed =
      Weigh(observed, {candidates[jump]}, search.circumstances).ranked[0];
  search.found = {{.candidate = jump,
                   .variant = candidates[jump].variants[weighed.variant],
                   .sizes_mm = weighed.sizes_mm,
                   .probability = 0.9,
                   .log_odds = weighed.log_odds,
                   .scale_mm = weighed.scale_mm}};
  return search;
}

struct Scrutinised {
  double gradual_nats = 0;  // Of the jump, before.
  std::string name{};
  Found found{};
  std::vector<std::string> rivals{};
};

Scrutinised AfterScrutiny(const Observed& observed) {
  const std::vector<Candidate> candidates = AllCandidates(observed);
  SearchResult search = OnlyLostSteps(observed, candidates);
  Scrutinised after{.gradual_nats = GradualOdds(observed,
                                                search.circumstances,
                                                candidates[search.found[0].candidate])};
  Scrutinise(observed, candidates, &search);
  if (search.found.empty()) return after;
  after.found = search.found[0];
  after.name = candidates[after.found.candidate].Name();
  for (const Rival& rival : after.found.rivals) {
    after.rivals.push_back(candidates[rival.candidate].Name());
  }
  return after;
}

TEST(Scrutiny, AClearJumpHasNoRivalOverTime) {
  const Scrutinised after = AfterScrutiny(RiseWithin(1, 12));

  EXPECT_EQ(after.name, "missed_steps.x");
  EXPECT_TRUE(after.rivals.empty());
  EXPECT_EQ(after.found.probability, 0.9);
}

// Between 1:20 and 20:1: the table has as much of the probability as the odds say.
TEST(Scrutiny, AJumpThatMayBeGradualHasTheTableOverTimeAsRival) {
  const Scrutinised after = AfterScrutiny(RiseWithin(4, 4));
  const double is_gradual = 1 / (1 + std::exp(-after.gradual_nats));

  ASSERT_LT(std::abs(after.gradual_nats), std::log(19.0));
  EXPECT_EQ(after.name, "missed_steps.x");
  ASSERT_EQ(after.rivals, std::vector<std::string>{"unknown.x{t}"});
  EXPECT_DOUBLE_EQ(after.found.rivals[0].probability, 0.9 * is_gradual);
  EXPECT_DOUBLE_EQ(after.found.probability, 0.9 * (1 - is_gradual));
}

}  // namespace
}  // namespace caltwin
