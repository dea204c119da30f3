// What forms a cause may have, and how likely each is beforehand.
#include "calibration/diagnosis/candidates.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/diagnosis/weighing.h"
#include "sim/base/rng.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

constexpr double kLead_mm = 5, kAmplitude_mm = 0.02, kSigma_mm = 0.002;
// 5 turns and 0.072 of one: seen at the places as 5 less 0.067 are, of a period 2.8 %
// longer.
constexpr double kApart_mm = 25.36;
constexpr int kPlaces = 12;

Machine WithScrew() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  machine.axes[0].max_mm = 400;
  machine.axes[0].lead_mm = kLead_mm;
  machine.settings.steps_per_mm[0] = machine.axes[0].steps_per_mm();
  return machine;
}

// A wave of the lead, read at places so far apart that other periods of the grid go
// through them about as well.
Observed FarApart() {
  Rng rng(5, 0, "candidates_test");
  RowTable table;
  for (int i = 0; i < kPlaces; ++i) {
    const double x_mm = kApart_mm * i;
    Row row{.row = i + 1, .campaign = "places"};
    row.cmd_mm = {x_mm, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm =
        kAmplitude_mm * std::sin(2 * std::numbers::pi * x_mm / kLead_mm + 0.4) +
        kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return {table, {}, WithScrew(), {}};
}

TEST(AllCandidates, AWaveMostLikelyHasTheLeadThatWasDrawn) {
  const Observed observed = FarApart();
  const std::vector<Candidate> all = AllCandidates(observed);
  const auto wave = std::ranges::find(all, "cyclic_lead.x", &Candidate::Name);
  ASSERT_NE(wave, all.end());
  ASSERT_GT(wave->variants.size(), 1U);

  double others = 0, as_drawn = 0;
  for (const Variant& variant : wave->variants) {
    (variant.forms[0] == kLead_mm ? as_drawn : others) += variant.weight;
  }
  EXPECT_NEAR(as_drawn / (as_drawn + others), 0.8, 1e-12);
}

TEST(AllCandidates, FormsThatNobodyDrewAreAlikeLikely) {
  for (const Candidate& candidate : AllCandidates(FarApart())) {
    for (const Variant& variant : candidate.variants) {
      const bool is_drawn = variant.forms.size() == 1 && variant.forms[0] == kLead_mm;
      if (!is_drawn) EXPECT_EQ(variant.weight, 1) << candidate.Name();
    }
  }
}

TEST(Weigh, TakesTheDrawnPeriodWhereOthersFitAsWell) {
  const Observed observed = FarApart();
  const std::vector<Candidate> all = AllCandidates(observed);
  const auto wave = std::ranges::find(all, "cyclic_lead.x", &Candidate::Name);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kPlaces);
  const Circumstances beside{
      .sigma_mm = ones * kSigma_mm,
      .nuisances = {{.name = "offset", .unit = "mm", .column_mm = ones, .prior_sd = 1}},
      .left_out = std::vector<bool>(kPlaces, false)};

  const Weighed weighed = Weigh(observed, {*wave}, beside).ranked[0];

  EXPECT_DOUBLE_EQ(wave->variants[weighed.variant].forms[0], kLead_mm);
  // With all of them alike likely another may be taken.
  Candidate even = *wave;
  double most = -HUGE_VAL, as_drawn = 0;
  for (const Variant& variant : wave->variants) {
    even.variants = {variant};
    const double log_odds = Weigh(observed, {even}, beside).ranked[0].log_odds;
    (variant.forms[0] == kLead_mm ? as_drawn : most) =
        variant.forms[0] == kLead_mm ? log_odds : std::max(most, log_odds);
  }
  EXPECT_LT(std::abs(most - as_drawn), 3) << "these places tell the periods apart";
}

}  // namespace
}  // namespace caltwin
