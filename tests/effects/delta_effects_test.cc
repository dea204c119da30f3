// Effects of a delta: their closed forms against the exact six-rod chain.

#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/kinds/delta_at.h"
#include "sim/effects/predict.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

Machine Delta() {
  Machine machine{.kind = DeltaKind(), .own = DeltaDrawing{}};
  for (AxisDrawing& axis : machine.axes) {
    axis = {.max_mm = 400,
            .lead_mm = 40,
            .is_belt = true,
            .moving_mass_kg = 0.15,
            .rail_friction_n = 6};
  }
  return machine;
}

Row RowAt(const Vec3<double>& at_mm) {
  Row row;
  for (std::size_t i = 0; i < 3; ++i) {
    row.cmd_mm[i] = at_mm[static_cast<Eigen::Index>(i)];
    row.motor_dir[i] = i == 1 ? -1 : 1;
  }
  return row;
}

const std::vector<Vec3<double>> kPlaces_mm = {
    {0, 0, 0}, {70, 10, 5}, {-40, 60, 30}, {-20, -80, 90}};

TEST(DeltaEffects, MoveTheNozzleAsTheExactChainDoes) {
  const Machine machine = Delta();
  const DeltaBuild<double> drawn = DeltaOf(machine).Build();
  int checked = 0;
  for (int index = 0; index < static_cast<int>(kNumEffects); ++index) {
    const Effect& effect = EffectAt(index);
    for (const std::string_view axis : AxesOn(effect, DeltaKind())) {
      Injected injected = NeutralEffect(index, axis, machine);
      // Small: what is left is of second order.
      for (double& value : injected.values) value += 0.01;
      const auto turns = TurnsOf(injected);
      if (turns.empty()) continue;
      DeltaBuild<double> built = drawn;
      DeltaBed<double> bed;
      for (const auto& [knob, by] : turns) TurnKnob(knob, by, &built, &bed);
      for (const Vec3<double>& place_mm : kPlaces_mm) {
        const auto here =
            LinkageAtOf(drawn, DeltaOf(machine).settings, RowAt(place_mm), place_mm);
        At at{.q_mm = place_mm, .n = {0, 0, 1}, .linkage = &*here};
        const Vec3<double> linear_mm =
            ErrorsAt<double>(machine, at, std::span(&injected, 1)).motion_mm;
        const auto pose = DeltaPoseOf(built, here->motors_mm);
        EXPECT_LT((pose->nozzle_mm - place_mm - linear_mm).norm(), 5e-6)
            << effect.name << "." << axis;
        ++checked;
      }
    }
  }
  EXPECT_GE(checked, 20 * static_cast<int>(kPlaces_mm.size()));
}

// A carriage that lags by half its gap is a motor that went less far; one that hangs in
// its drive is always as after a move up.
class PlayOfACarriage : public ::testing::TestWithParam<bool> {};

TEST_P(PlayOfACarriage, IsAShorterTravel) {
  const bool hangs = GetParam();
  Machine machine = Delta();
  for (AxisDrawing& axis : machine.axes) axis.moving_mass_kg = hangs ? 0.7 : 0.15;
  const DeltaBuild<double> drawn = DeltaOf(machine).Build();
  constexpr double kGap_mm = 0.02;
  for (std::size_t tower = 0; tower < 3; ++tower) {
    const Injected play{.effect = EffectIndex<CarriageBacklash>(),
                        .axis = TowerName(static_cast<int>(tower)),
                        .values = {kGap_mm}};
    for (const Vec3<double>& place_mm : kPlaces_mm) {
      const auto here =
          LinkageAtOf(drawn, DeltaOf(machine).settings, RowAt(place_mm), place_mm);
      const At at{.q_mm = place_mm, .n = {0, 0, 1}, .linkage = &*here};
      const Vec3<double> moved_mm =
          ErrorsAt<double>(machine, at, std::span(&play, 1)).motion_mm;
      Vec3<double> motors_mm = here->motors_mm;
      const auto i = static_cast<Eigen::Index>(tower);
      motors_mm[i] -= (hangs ? -1 : here->motor_dir[i]) * kGap_mm / 2;
      const auto pose = DeltaPoseOf(drawn, motors_mm);
      EXPECT_LT((pose->nozzle_mm - place_mm - moved_mm).norm(), 2e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Hanging, PlayOfACarriage, ::testing::Bool());

TEST(DeltaEffects, LiftTheRimOfTheBedByTheirHeight) {
  const Machine machine = Delta();
  const Vec3<double> rim_mm(100 / std::numbers::sqrt2, 100 / std::numbers::sqrt2, 0);
  auto here = LinkageAtOf(
      DeltaOf(machine).Build(), DeltaOf(machine).settings, RowAt(rim_mm), rim_mm);
  const At at{.q_mm = rim_mm,
              .n = {0, 0, 1},
              .on_table = true,
              .rim_mm = 100,
              .linkage = &*here};
  const auto height_mm = [&](int effect, const std::string& axis) {
    const Injected shape{.effect = effect, .axis = axis, .values = {50}};
    return ErrorsAt<double>(machine, at, std::span(&shape, 1)).artefact_mm;
  };
  EXPECT_NEAR(height_mm(EffectIndex<BedBowl>(), ""), 0.05, 1e-12);
  EXPECT_NEAR(height_mm(EffectIndex<BedTwist>(), ""), 0.05, 1e-12);
  // A trough: at 45 degrees half as high as on the rim along its axis.
  EXPECT_NEAR(height_mm(EffectIndex<BedCylinder>(), "x"), 0.025, 1e-12);
}

TEST(DeltaEffects, AreNoneOfARouter) {
  EXPECT_TRUE(HasAxis(TowerLean::kDeclaration, "a", DeltaKind()));
  EXPECT_FALSE(HasAxis(TowerLean::kDeclaration, "a", CartesianKind()));
  EXPECT_FALSE(HasAxis(Squareness::kDeclaration, "C0Y", DeltaKind()));
}

}  // namespace
}  // namespace caltwin
