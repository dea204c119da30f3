#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/effects/catalog.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

Machine Delta(double rail_friction_n) {
  Machine machine{.kind = DeltaKind(), .own = DeltaDrawing{}};
  for (AxisDrawing& tower : machine.axes) {
    tower = {.max_mm = 400,
             .lead_mm = 40,
             .is_belt = true,
             .full_steps_per_rev = 200,
             .microsteps = 256,
             .moving_mass_kg = 0.15,
             .rail_friction_n = rail_friction_n};
  }
  return machine;
}

BuiltDelta Loose(const Machine& machine, const CarriageGaps_mm& gaps_mm) {
  BuiltDelta built{.build = DeltaOf(machine).Build(), .play_mm = gaps_mm};
  built.build.model.endstop_mm = {300.2, 299.9, 300.1};
  built.build.model.radius_mm.fill(130.3);
  built.bed.slope_x = 1e-3;
  return built;
}

// Rails that hold more than ever hangs on them, less, and some of both: MuJoCo decides
// by friction and weight, the closed form by what it says of them.
class LooseDelta : public ::testing::TestWithParam<double> {};

TEST_P(LooseDelta, IsTouchedInMujocoWhereTheClosedFormSays) {
  constexpr double kMust_mm = 1e-4;
  const Machine machine = Delta(GetParam());
  const BuiltDelta built = Loose(machine, {0, 0.03, 0.06});
  const DeltaModel<double>& settings = DeltaOf(machine).settings;
  DeltaWorld world = WorldOfDelta(machine, built);

  for (const auto& [x, y] : {std::pair(0, 0), {0, 80}, {60, -40}}) {
    const auto exact = TouchOfDelta_mm(nullptr, machine, built, settings, {x, y});
    const auto touched = TouchOfDelta_mm(&world, machine, built, settings, {x, y});
    ASSERT_TRUE(exact && touched) << x << " " << y;
    EXPECT_LT(std::abs(*touched - *exact), kMust_mm) << x << " " << y;
  }
}

INSTANTIATE_TEST_SUITE_P(Friction_n, LooseDelta, ::testing::Values(0.5, 2.75, 6.0));

// A probe's half newton takes off the effector's share: near tower c a rail of 4.2 N
// holds what it would not without.
struct ProbeOnPlay {
  double friction_n = 0, pretravel_mm = 0, gap_mm = 0;
};
class LooseDeltaWithAProbe : public ::testing::TestWithParam<ProbeOnPlay> {};

TEST_P(LooseDeltaWithAProbe, IsTouchedInMujocoWhereTheClosedFormSays) {
  constexpr double kMust_mm = 1e-4;
  const ProbeOnPlay& param = GetParam();
  const Machine machine = Delta(param.friction_n);
  BuiltDelta built = Loose(machine, {0, 0, param.gap_mm});
  built.tip.pretravel_mm = param.pretravel_mm;
  const DeltaModel<double>& settings = DeltaOf(machine).settings;
  DeltaWorld world = WorldOfDelta(machine, built);

  for (const auto& [x, y] : {std::pair(0, 80), {60, -40}}) {
    const auto exact = TouchOfDelta_mm(nullptr, machine, built, settings, {x, y});
    const auto touched = TouchOfDelta_mm(&world, machine, built, settings, {x, y});
    ASSERT_TRUE(exact && touched) << x << " " << y;
    EXPECT_LT(std::abs(*touched - *exact), kMust_mm) << x << " " << y;
  }
}

INSTANTIATE_TEST_SUITE_P(Machines,
                         LooseDeltaWithAProbe,
                         ::testing::Values(ProbeOnPlay{0.5, 0.3, 0.06},
                                           ProbeOnPlay{4.2, 0.3, 0.06},
                                           ProbeOnPlay{4.2, 0.1, 0.06},
                                           ProbeOnPlay{6.0, 0.3, 0.06}));

// The carriage needs a hundredth of a millimetre to stop, and the nozzle comes down by
// a fifth of what the drives do: MuJoCo's trigger is 0.08 mm from that of a standstill.
TEST(TouchOfDelta, RefusesATriggerThatSpeedDecides) {
  const Machine machine = Delta(4.2);
  BuiltDelta built = Loose(machine, {0, 0, 0.3});
  built.tip.pretravel_mm = 0.02;

  try {
    TouchOfDelta_mm(nullptr, machine, built, DeltaOf(machine).settings, {0, 80});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("carriage c stops in its play"));
  }
}

// A touch comes down: it is that of a machine whose endstop stands half a gap higher.
TEST(TouchOfDelta, ATouchCannotTellPlayFromAnEndstop) {
  constexpr double kSolved_mm = 1e-9;
  const Machine machine = Delta(6);
  BuiltDelta as_endstop = Loose(machine, {});
  as_endstop.build.model.endstop_mm[2] += 0.03;

  for (const auto& [x, y] : {std::pair(0, 0), {0, 80}, {60, -40}}) {
    const auto touch = [&](const BuiltDelta& built) {
      return *TouchOfDelta_mm(
          nullptr, machine, built, DeltaOf(machine).settings, {x, y});
    };
    EXPECT_NEAR(touch(Loose(machine, {0, 0, 0.06})), touch(as_endstop), kSolved_mm);
  }
}

TEST(BuildPlayIn, PlayAmongTheEffectsIsBuiltInAndTheRestLeft) {
  std::vector<Injected> effects = {
      {.effect = EffectIndex<CarriageBacklash>(), .axis = "b", .values = {0.05}},
      {.effect = EffectIndex<TriggerLatency>(), .axis = "", .values = {1}}};
  BuiltDelta built;

  BuildPlayIn(&effects, &built);

  EXPECT_EQ(built.play_mm, (CarriageGaps_mm{0, 0.05, 0}));
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(effects[0].effect, EffectIndex<TriggerLatency>());
}

}  // namespace
}  // namespace caltwin
