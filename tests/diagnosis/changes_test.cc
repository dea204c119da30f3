// What changed between two campaigns, where what changed is known.
#include "calibration/diagnosis/changes.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 1e-3;
constexpr double kOf95_sd = 1.96;
constexpr int kPlaces = 40;
constexpr double kLead_mm = 4;

Machine Plain() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

struct Truth {
  double scale_ppm = 0;
  double gap_mm = 0;
  double wave_mm = 0;
};

// A laser along x, to and fro, at places that no turn of the screw divides.
RowTable Measured(const Truth& truth, Rng* rng, double span_mm = 260) {
  RowTable table;
  for (int i = 0; i < 2 * kPlaces; ++i) {
    const int place = i / 2;
    const double u = std::fmod(0.5 + 0.61803398875 * place, 1.0);
    const double sense = i % 2 == 0 ? 1 : -1;
    Row row{.row = i + 1, .campaign = "laser"};
    row.t_s = 10 * i;
    row.cmd_mm = {20 + span_mm * u, 0, 0};
    row.dir = {sense, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm =
        FractionFromPpm(truth.scale_ppm) * row.cmd_mm[0] - truth.gap_mm / 2 * sense +
        truth.wave_mm * std::sin(2 * std::numbers::pi * row.cmd_mm[0] / kLead_mm) +
        kSigma_mm * rng->Normal();
    table.rows.push_back(row);
  }
  return table;
}

// What a diagnosis says that found the wave (or nothing), its other figures left aside.
Diagnosis Said(const Observed& rows, double wave_mm) {
  Diagnosis diagnosis;
  diagnosis.sigma_mm = Eigen::VectorXd::Constant(rows.num_rows(), kSigma_mm);
  for (const char* name : {"scale.x", "backlash.x"}) {
    diagnosis.baseline.push_back({.name = name, .unit = "mm"});
  }
  if (wave_mm == 0) return diagnosis;
  const int cyclic = *FindEffect("cyclic_lead");
  Finding finding{.cause = "cyclic_lead", .axis = "x", .peak_um = UmFromMm(wave_mm)};
  finding.effect = NeutralEffect(cyclic, "x", rows.machine());
  const auto parameters = EffectAt(cyclic).parameters;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].name == "amplitude_um") {
      finding.effect->values[p] = UmFromMm(wave_mm);
    }
    if (parameters[p].name == "period_mm") finding.effect->values[p] = kLead_mm;
  }
  finding.change_mm = rows.Change_mm(*finding.effect);
  diagnosis.findings.push_back(finding);
  return diagnosis;
}

std::vector<Change> Changes(const Truth& before, const Truth& now, std::uint64_t seed) {
  Rng rng(seed, 0, "changes_test");
  const Observed earlier(Measured(before, &rng), {}, Plain(), {});
  const Observed later(Measured(now, &rng), {}, Plain(), {});
  const Diagnosis said_before = Said(earlier, before.wave_mm);
  const Diagnosis said_now = Said(later, now.wave_mm);
  return ChangesSince({earlier, said_before}, {later, said_now});
}

std::optional<Change> Named(const std::vector<Change>& changes, const char* name) {
  for (const Change& change : changes) {
    if (change.name == name) return change;
  }
  return std::nullopt;
}

bool Covers(const Change& change, double truth) {
  const double sd = std::hypot(change.before_sd, change.now_sd);
  return std::abs(change.now - change.before - truth) < kOf95_sd * sd;
}

// The wave of the later campaign stands in the earlier one too, half as large, though
// that was not said there. 95 % of 200 within four standard deviations of that count.
TEST(ChangesSince, IntervalsCoverAKnownChange) {
  constexpr int kPairs = 200;
  constexpr int kLow = 178, kHigh = 200;
  int scale = 0, gap = 0, wave = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    Rng rng(seed, 0, "changes_test");
    const Truth before{.scale_ppm = 20, .gap_mm = 0.01, .wave_mm = 0.003};
    const Truth now{.scale_ppm = 35, .gap_mm = 0.014, .wave_mm = 0.006};
    const Observed earlier(Measured(before, &rng), {}, Plain(), {});
    const Observed later(Measured(now, &rng), {}, Plain(), {});
    const Diagnosis said_before = Said(earlier, 0), said_now = Said(later, 0.006);

    const auto changes = ChangesSince({earlier, said_before}, {later, said_now});

    scale += Covers(*Named(changes, "scale.x"), 15) ? 1 : 0;
    gap += Covers(*Named(changes, "backlash.x"), 0.004) ? 1 : 0;
    wave += Covers(*Named(changes, "cyclic_lead.x"), 3) ? 1 : 0;
  }

  RecordProperty("scale", scale);
  RecordProperty("gap", gap);
  RecordProperty("wave", wave);
  for (const int covered : {scale, gap, wave}) {
    EXPECT_GE(covered, kLow);
    EXPECT_LE(covered, kHigh);
  }
}

// At one place a scale and the place of the laser are the same.
TEST(ChangesSince, WhatTheRowsDoNotTellIsNotCompared) {
  Rng rng(7, 0, "changes_test");
  const Observed earlier(
      Measured({.gap_mm = 0.01}, &rng, /*span_mm=*/0), {}, Plain(), {});
  const Observed later(Measured({.gap_mm = 0.02}, &rng), {}, Plain(), {});
  const Diagnosis said_before = Said(earlier, 0), said_now = Said(later, 0);

  const auto changes = ChangesSince({earlier, said_before}, {later, said_now});

  const auto gap = Named(changes, "backlash.x"), scale = Named(changes, "scale.x");
  ASSERT_TRUE(gap && scale);
  EXPECT_TRUE(gap->is_more_than_noise);
  EXPECT_FALSE(scale->before_is_determined);
  EXPECT_TRUE(scale->now_is_determined);
  EXPECT_FALSE(scale->is_more_than_noise);
}

TEST(ChangesSince, OfTheSameMachineNothingChanges) {
  const Truth truth{.scale_ppm = 20, .gap_mm = 0.01, .wave_mm = 0.005};

  for (const Change& change : Changes(truth, truth, 8)) {
    EXPECT_FALSE(change.is_more_than_noise) << change.name;
  }
}

}  // namespace
}  // namespace caltwin
