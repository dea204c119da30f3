// Every effect, on every axis it has: what MuJoCo reads is what the closed form says.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/twin/measured_rows.h"

namespace caltwin {
namespace {

constexpr double kMust_mm = 0.5e-3;  // docs/fidelities.md.

class EveryEffectMeasured : public ::testing::TestWithParam<int> {};

TEST_P(EveryEffectMeasured, ReadsInPhysicsAsInClosedForm) {
  const Machine machine = Gantry();
  static const PlannedSession kSession = SomeOfEverything();
  static const std::vector<double> kPlain_mm = Read_mm(kSession, {}, Fidelity::kFast);
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    const std::vector<Injected> effects{LargeEffect(GetParam(), axis, machine)};

    const auto fast_mm = Read_mm(kSession, effects, Fidelity::kFast);
    const auto physics_mm = Read_mm(kSession, effects, Fidelity::kPhysics);

    ASSERT_EQ(fast_mm.size(), physics_mm.size());
    double shown_mm = 0;
    for (std::size_t i = 0; i < fast_mm.size(); ++i) {
      const Row& row = kSession.rows[i];
      shown_mm = std::max(shown_mm, std::abs(fast_mm[i] - kPlain_mm[i]));
      EXPECT_NEAR(
          physics_mm[i], fast_mm[i], kMust_mm + Neglected_mm(effects[0], row, machine))
          << axis << " row " << row.row << " " << row.campaign << " " << row.feature;
    }
    RecordProperty(std::string(axis), fmt::format("{:.1f} um", shown_mm * 1e3));
  }
}

INSTANTIATE_TEST_SUITE_P(Effects,
                         EveryEffectMeasured,
                         ::testing::ValuesIn(EffectsOfAGantry()),
                         [](const auto& effect) {
                           return std::string(EffectAt(effect.param).name);
                         });

}  // namespace
}  // namespace caltwin
