// Estimators push automatic derivatives through every closed form: none may be cut.
#include <algorithm>
#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

using Jet = ceres::Jet<double, 1>;

const Climate& SomeClimate() {
  static const Climate kClimate = [] {
    Climate climate;
    for (std::size_t i = 0; i < kNumSensors; ++i) {
      climate.logs[i].Add(0, 20);
      climate.logs[i].Add(19900, 22);
      climate.logs[i].Add(20100, 24 + static_cast<double>(i));
    }
    return climate;
  }();
  return kClimate;
}

At SomeReading(RowKind kind) {
  return {.kind = kind,
          .q_mm = {210, 40, 17},
          .dir = {1, -1, -1},
          .n = Vec3<double>(-0.8, 0.36, 0.48).normalized(),
          .steps_per_mm = {800, 800, 800},
          .tip_radius_cfg_mm = 1,
          .feed_mm_s = 2,
          .on_table = kind == RowKind::kTouch,
          .t_s = 20000,
          .home = "1",
          .climate = &SomeClimate(),
          .since_rev_mm = {0.3, 0.2, 0.1},
          .probe_angle_deg = 40,
          .probe_off_mm = {0, 40, 3},
          .artefact = "block",
          .artefact_turn_deg = 90,
          .artefact_mid_mm = {200, 50, 10},
          .radius_mm = kind == RowKind::kRadial ? 100.0 : 0};
}

// Near what is usual, inside the bounds.
Injected Usual(int effect, std::string_view axis) {
  Injected usual = NeutralEffect(effect, axis, Machine{});
  for (std::size_t i = 0; i < usual.values.size(); ++i) {
    const Parameter& p = EffectAt(effect).parameters[i];
    const double middle = Middle(p.prior);
    const double off_middle = middle + 0.3 * std::max(1.0, std::abs(middle) / 10);
    usual.values[i] = std::clamp(off_middle, p.min, p.max);
  }
  return usual;
}

double Derivative(const Injected& at_values, std::size_t parameter, const At& at) {
  Valued<Jet> valued{.effect = at_values.effect, .axis = at_values.axis};
  for (const double value : at_values.values) valued.values.emplace_back(value);
  valued.values[parameter].v[0] = 1;
  return Predict_mm<Jet>(Machine{}, at, std::span<const Valued<Jet>>(&valued, 1)).v[0];
}

double CentralDifference(const Injected& at_values,
                         std::size_t parameter,
                         double step,
                         const At& at) {
  Injected plus = at_values, minus = at_values;
  plus.values[parameter] += step;
  minus.values[parameter] -= step;
  const auto value_mm = [&](const Injected& effect) {
    return Predict_mm<double>(Machine{}, at, std::span<const Injected>(&effect, 1));
  };
  return (value_mm(plus) - value_mm(minus)) / (2 * step);
}

class EveryDerivative : public ::testing::TestWithParam<int> {};

TEST_P(EveryDerivative, EqualsTheDifferenceOfTheClosedForm) {
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    const Injected usual = Usual(GetParam(), axis == kAnyAxis ? "block" : axis);
    for (const RowKind kind : {RowKind::kPosition, RowKind::kTouch, RowKind::kRadial}) {
      const At at = SomeReading(kind);
      for (std::size_t i = 0; i < usual.values.size(); ++i) {
        const double step = 1e-6 * std::abs(usual.values[i]);
        const double derivative = Derivative(usual, i, at);
        // The value's last digit over the step, and the third derivative times its
        // square.
        const double rounding = 4e-15 * 100 / step;
        EXPECT_NEAR(derivative,
                    CentralDifference(usual, i, step, at),
                    rounding + 1e-6 * std::abs(derivative))
            << axis << ' ' << EffectAt(GetParam()).parameters[i].name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryDerivative,
                         ::testing::Range(0, static_cast<int>(kNumEffects)),
                         [](const auto& test) {
                           return std::string(EffectAt(test.param).name);
                         });

}  // namespace
}  // namespace caltwin
