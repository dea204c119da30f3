#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Machine Gantry() {
  Machine machine{.name = "test"};
  machine.axes[2].home = HomeEnd::kMax;
  machine.axes[2].counterbalance_n = machine.axes[2].moving_mass_kg * kGravity_m_s2;
  return machine;
}

// A day on which every part warmed by another amount.
const Climate& SomeClimate() {
  static const Climate kClimate = [] {
    Climate climate;
    for (std::size_t i = 0; i < kNumSensors; ++i) {
      climate.logs[i].Add(0, 20);
      climate.logs[i].Add(2000, 24 + static_cast<double>(i));
    }
    return climate;
  }();
  return kClimate;
}

At SomeTouch() {
  return {.q_mm = {210, 40, 17},
          .dir = {1, -1, -1},
          .n = Vec3<double>(-0.8, 0.36, 0.48).normalized(),
          .steps_per_mm = {800, 800, 800},
          .tip_radius_cfg_mm = 1,
          .feed_mm_s = 2,
          .on_table = true,
          .t_s = 1000,
          .home = "1",
          .climate = &SomeClimate(),
          .since_rev_mm = {0.3, 0.2, 0.1},
          .probe_angle_deg = 20,
          .probe_off_mm = {5, 30, -10},
          .artefact = kAnyAxis,
          .artefact_turn_deg = 10,
          .artefact_mid_mm = {180, 60, 10}};
}

// A ball-bar's reading: what only shows while circling.
At SomeCircle() {
  At at = SomeTouch();
  at.kind = RowKind::kRadial;
  at.n = {0.8, 0.6, 0};
  at.dir = {-1, 1, 0};
  at.feed_mm_s = 30;
  at.radius_mm = 150;
  return at;
}

// Whether anything of what an effect may add to differs.
bool Differ(const Errors<double>& a, const Errors<double>& b) {
  return a.motion_mm != b.motion_mm || a.lost_motion_mm != b.lost_motion_mm ||
         a.pretravel_mm != b.pretravel_mm ||
         a.more_pretravel_mm != b.more_pretravel_mm ||
         a.tip_radius_mm != b.tip_radius_mm || a.artefact_mm != b.artefact_mm ||
         a.latency_s != b.latency_s || a.scatter_mm2 != b.scatter_mm2;
}

class EveryEffect : public ::testing::TestWithParam<int> {};

TEST_P(EveryEffect, IsDocumentedAndHasAUsablePrior) {
  const Effect& effect = EffectAt(GetParam());
  for (const std::string_view words : {effect.about,
                                       effect.formula,
                                       effect.source,
                                       effect.twin,
                                       effect.words.plot,
                                       effect.words.values,
                                       effect.words.cause,
                                       effect.words.effect,
                                       effect.words.action}) {
    EXPECT_THAT(words, Not(IsEmpty()));
  }
  const auto kinds = AllMachineKinds();
  EXPECT_TRUE(std::ranges::any_of(kinds, [&](const MachineKind* kind) {
    return !AxesOn(effect, kind).empty();
  })) << "on no machine";
  for (const Parameter& p : effect.parameters) {
    EXPECT_LT(p.min, p.max) << p.name;
    EXPECT_GE(Middle(p.prior), p.min) << p.name;
    EXPECT_LE(Middle(p.prior), p.max) << p.name;
    EXPECT_THAT(std::string(p.name), HasSubstr("_")) << "carries no unit";
  }
}

TEST_P(EveryEffect, AtItsNeutralValuesChangesNoErrorAnywhere) {
  const Machine machine = Gantry();
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    const std::vector<Injected> neutral{NeutralEffect(GetParam(), axis, machine)};

    for (const At& at : {SomeTouch(), SomeCircle()}) {
      EXPECT_FALSE(Differ(ErrorsAt<double>(machine, at, neutral),
                          ErrorsAt<double>(machine, at, {})))
          << axis;
    }
  }
}

TEST_P(EveryEffect, ChangesSomethingAwayFromItsNeutralValues) {
  const Machine machine = Gantry();
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    std::vector<Injected> moved{NeutralEffect(GetParam(), axis, machine)};
    for (double& value : moved[0].values)
      value += 0.01 * std::max(1.0, std::abs(value));

    bool changes = false;
    for (const At& at : {SomeTouch(), SomeCircle()}) {
      changes = changes || Differ(ErrorsAt<double>(machine, at, moved),
                                  ErrorsAt<double>(machine, at, {}));
    }
    EXPECT_TRUE(changes) << axis;
  }
}

std::vector<int> AllIndices() {
  std::vector<int> indices;
  for (int i = 0; i < static_cast<int>(kNumEffects); ++i) indices.push_back(i);
  return indices;
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryEffect,
                         ::testing::ValuesIn(AllIndices()),
                         [](const auto& test) {
                           return std::string(EffectAt(test.param).name);
                         });

}  // namespace
}  // namespace caltwin
