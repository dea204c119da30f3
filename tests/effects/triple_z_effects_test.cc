// Effects of a triple-Z printer: neutral values, derivatives, how the bed moves.

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

using Jet = ceres::Jet<double, 1>;

Machine Printer() {
  Machine machine{.kind = TripleZKind(), .own = TripleZDrawing{}};
  machine.axes[0].max_mm = machine.axes[1].max_mm = 235;
  machine.axes[2] = {.max_mm = 250, .home = HomeEnd::kMax};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// A gauge's reading with its screws apart, each in its own sense.
Row SomeReading() {
  Row row{.kind = RowKind::kPosition};
  row.cmd_mm = {170, 60, 90};
  row.motor_mm = {160.3, 160.9, 159.2};
  row.dir = {0, 0, 1};
  row.motor_dir = {1, -1, -1};
  row.n = {0, 0, 1};
  row.probe_off_mm = {0, 25, 0};
  row.feature = "bed.top";
  return row;
}

At SomeAt(const Machine& machine) {
  At at = AtOf(SomeReading(), machine, machine.settings);
  at.t_s = 100;
  at.homed_at_s = 0;
  return at;
}

Injected Usual(int index, std::string_view axis, const Machine& machine) {
  Injected usual = NeutralEffect(index, axis, machine);
  for (std::size_t i = 0; i < usual.values.size(); ++i) {
    const Parameter& p = EffectAt(index).parameters[i];
    const double middle = Middle(p.prior);
    usual.values[i] =
        std::clamp(middle + 0.3 * std::max(1.0, std::abs(middle) / 10), p.min, p.max);
  }
  return usual;
}

template <typename Check>
void ForEveryEffect(const Check& check) {
  for (int index = 0; index < static_cast<int>(kNumEffects); ++index) {
    for (const std::string_view axis : AxesOn(EffectAt(index), TripleZKind())) {
      SCOPED_TRACE(std::string(EffectAt(index).name) + "." + std::string(axis));
      check(index, axis);
    }
  }
}

TEST(TripleZEffects, AtTheirNeutralValuesChangeNothing) {
  const Machine machine = Printer();
  const At at = SomeAt(machine);
  const double drawn_mm = Predict_mm<double>(machine, at, {});
  ForEveryEffect([&](int index, std::string_view axis) {
    const Injected neutral = NeutralEffect(index, axis, machine);
    EXPECT_DOUBLE_EQ(Predict_mm<double>(machine, at, std::span(&neutral, 1)), drawn_mm);
  });
}

TEST(TripleZEffects, CarryTheirDerivatives) {
  const Machine machine = Printer();
  const At at = SomeAt(machine);
  int seen = 0;
  ForEveryEffect([&](int index, std::string_view axis) {
    const Injected usual = Usual(index, axis, machine);
    for (std::size_t i = 0; i < usual.values.size(); ++i) {
      Valued<Jet> valued{.effect = index, .axis = usual.axis};
      for (const double value : usual.values) valued.values.emplace_back(value);
      valued.values[i].v[0] = 1;
      const double derivative =
          Predict_mm<Jet>(machine, at, std::span<const Valued<Jet>>(&valued, 1)).v[0];
      const double step = 1e-6 * std::max(std::abs(usual.values[i]), 1e-3);
      const auto value_mm = [&](double by) {
        Injected moved = usual;
        moved.values[i] += by;
        return Predict_mm<double>(machine, at, std::span(&moved, 1));
      };
      const double rounding = 4e-15 * 300 / step;
      EXPECT_NEAR(derivative,
                  (value_mm(step) - value_mm(-step)) / (2 * step),
                  rounding + 1e-6 * std::abs(derivative))
          << EffectAt(index).parameters[i].name;
      seen += derivative != 0 ? 1 : 0;
    }
  });
  EXPECT_GE(seen, 25);
}

// Effects together are one machine: heights of the screws by its own wiring and pitch,
// the plane through where they stand.
TEST(TripleZEffects, TogetherAreOneMachine) {
  const Machine machine = Printer();
  const At at = SomeAt(machine);
  const std::vector<Injected> all = {
      {.effect = EffectIndex<MotorsSwapped>(), .axis = "z1z3", .values = {1}},
      {.effect = EffectIndex<PivotPosition>(), .axis = "z2", .values = {-20, 11}},
      {.effect = EffectIndex<ScrewPitch>(), .axis = "z2", .values = {700}}};
  Vec3<double> heights_mm(159.2, 160.9, 160.3);
  heights_mm[1] += 700e-6 * 160.9;
  Pivots<double> pivots_mm = TripleZOf(machine).pivots_mm();
  pivots_mm[1] += Eigen::Vector2d(-20, 11);

  const double nozzle_over_bed_mm =
      250 - ScrewWeights<double>(pivots_mm, 170, 85).dot(heights_mm);

  EXPECT_NEAR(Predict_mm<double>(machine, at, all), nozzle_over_bed_mm - 90, 1e-12);
}

// The bed's height there with its screws told so, and what it differs by from as drawn.
double BedAt_mm(const std::vector<Injected>& effects,
                const Vec3<double>& told_mm,
                const Eigen::Vector2d& at_mm) {
  const Machine machine = Printer();
  Row row = SomeReading();
  row.cmd_mm = {at_mm[0], at_mm[1], 90};
  row.probe_off_mm = {0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    row.motor_mm[i] = told_mm[static_cast<Eigen::Index>(i)];
  }
  const At at = AtOf(row, machine, machine.settings);
  return 250 - 90 - Predict_mm<double>(machine, at, effects);
}

// By hand: what one driver is told the screw behind it in the name does.
TEST(TripleZEffects, ARingOfMotorsPassesOnWhatEachIsTold) {
  const auto heights_mm = [](const std::string& wiring) {
    const std::vector<Injected> swapped = {
        {.effect = EffectIndex<MotorsSwapped>(), .axis = wiring, .values = {1}}};
    const Vec3<double> told_mm(161, 162, 164);
    return Vec3<double>(BedAt_mm(swapped, told_mm, {20, 20}),
                        BedAt_mm(swapped, told_mm, {215, 20}),
                        BedAt_mm(swapped, told_mm, {20, 215}));
  };
  const std::vector<std::pair<std::string, Vec3<double>>> wirings = {
      {"z1z2", {162, 161, 164}},
      {"z1z3", {164, 162, 161}},
      {"z2z3", {161, 164, 162}},
      {"z1z2z3", {164, 161, 162}},
      {"z1z3z2", {162, 164, 161}}};
  for (const auto& [wiring, expected_mm] : wirings) {
    EXPECT_LT((heights_mm(wiring) - expected_mm).norm(), 1e-10) << wiring;
  }
}

Injected Held(double stiffness_ratio_mm2) {
  return {.effect = EffectIndex<OverconstrainedBed>(),
          .axis = "",
          .values = {stiffness_ratio_mm2}};
}

// Screw 1 down, 2 and 3 up by half: the softest tilt, K = 195^2 / 3 there. Guides as
// stiff as that leave half of it; of a rise of all three nothing.
TEST(TripleZEffects, GuidesAsStiffAsTheScrewsHalveATilt) {
  constexpr double kSoftest_mm2 = 195.0 * 195 / 3;
  const Vec3<double> tilted_mm(159, 160.5, 160.5);
  for (const Eigen::Vector2d& at_mm :
       {Eigen::Vector2d(20, 20), Eigen::Vector2d(180, 90)}) {
    const double free_mm = BedAt_mm({}, tilted_mm, at_mm) - 160;
    EXPECT_NEAR(
        BedAt_mm({Held(kSoftest_mm2)}, tilted_mm, at_mm) - 160, free_mm / 2, 1e-11);
    EXPECT_NEAR(BedAt_mm({Held(kSoftest_mm2)}, {163, 163, 163}, at_mm), 163, 1e-11);
  }
  EXPECT_NEAR(BedAt_mm({}, tilted_mm, {20, 20}), 159, 1e-11);
}

// Forces and moments, each in units of one screw's stiffness: the supports' sum to
// nothing, their moment is the guides'.
TEST(TripleZEffects, AnOverconstrainedBedIsInBalance) {
  constexpr double kHeld_mm2 = 3000;
  const Vec3<double> told_mm(159.2, 161.1, 160.4);
  const std::vector<Injected> effects = {
      Held(kHeld_mm2),
      {.effect = EffectIndex<PivotPosition>(), .axis = "z3", .values = {70, -12}}};
  const std::array<Eigen::Vector2d, 3> at_mm = {
      Eigen::Vector2d(20, 20), Eigen::Vector2d(215, 20), Eigen::Vector2d(90, 203)};
  const Eigen::Vector2d middle_mm = (at_mm[0] + at_mm[1] + at_mm[2]) / 3;
  const double middle_height_mm = BedAt_mm(effects, told_mm, middle_mm);
  const Eigen::Vector2d tilt =
      Eigen::Vector2d(BedAt_mm(effects, told_mm, middle_mm + Eigen::Vector2d(100, 0)),
                      BedAt_mm(effects, told_mm, middle_mm + Eigen::Vector2d(0, 100))) /
          100 -
      Eigen::Vector2d::Constant(middle_height_mm / 100);

  double force_mm = 0;
  Eigen::Vector2d moment_mm2 = kHeld_mm2 * tilt;
  for (std::size_t i = 0; i < 3; ++i) {
    const double give_mm =
        BedAt_mm(effects, told_mm, at_mm[i]) - told_mm[static_cast<Eigen::Index>(i)];
    force_mm += give_mm;
    moment_mm2 += give_mm * (at_mm[i] - middle_mm);
  }

  EXPECT_GT(kHeld_mm2 * tilt.norm(), 10);
  EXPECT_NEAR(force_mm, 0, 1e-10);
  EXPECT_NEAR(moment_mm2.norm(), 0, 1e-8);
}

TEST(TripleZEffects, ScaleIsThatOfTheScrews) {
  Machine machine = Printer();
  const At at = SomeAt(machine);
  const double drawn_mm = Predict_mm<double>(machine, at, {});
  const Injected scale{
      .effect = EffectIndex<StepsPerMm>(), .axis = "z", .values = {800 / 1.001}};

  const double bed_mm = at.screws->weights.dot(*ScrewsOf_mm(at));

  EXPECT_NEAR(Predict_mm<double>(machine, at, std::span(&scale, 1)) - drawn_mm,
              -0.001 * bed_mm,
              1e-12);
}

}  // namespace
}  // namespace caltwin
