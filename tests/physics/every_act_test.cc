#include <algorithm>
#include <variant>

#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/effects/acts/acts.h"
#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/physics/world.h"

namespace caltwin {
namespace {

constexpr double kTimestep_s = 2e-4;
// Rounding of the model's metres; what the solver leaves (PHYSICS.md: 1e-5 um).
constexpr double kPlaced_mm = 1e-9;
constexpr double kHeld_mm = 1e-7;

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

// The gantry's model before effects, read once.
const Mjcf& Drawn() {
  static const Mjcf kDrawn = ModelOf(Gantry());
  return kDrawn;
}

class EveryAct : public ::testing::TestWithParam<int> {};

TEST_P(EveryAct, StandsAtItsEffectsPlaceInTheCatalog) {
  const ActOf& act = AllActs()[static_cast<std::size_t>(GetParam())];

  EXPECT_EQ(act.effect, GetParam());
  EXPECT_EQ(act.kind == ActKind::kEditModel, act.edit != nullptr);
}

TEST_P(EveryAct, AtItsNeutralValuesLeavesTheModelUntouched) {
  const Machine machine = Gantry();
  static const std::string kBefore = Drawn().ToText();
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    Mjcf model = Drawn().Copy();

    EditModel(machine, std::vector{NeutralEffect(GetParam(), axis, machine)}, &model);

    EXPECT_EQ(model.ToText(), kBefore) << axis;
  }
}

// Effects of the frame that are built into the model: they move the tip, wherever the
// axes stand. Compared with `Add`, at 20 times the size expected.
class EveryFrameAct : public ::testing::TestWithParam<int> {
 protected:
  static std::vector<Injected> Large(std::string_view axis, const Machine& machine) {
    std::vector<Injected> injected{NeutralEffect(GetParam(), axis, machine)};
    const Parameter& parameter = EffectAt(GetParam()).parameters[0];
    injected[0].values[0] = 20 * std::get<Normal>(parameter.prior).sd;
    return injected;
  }
  static World WorldWith(const Machine& machine,
                         const std::vector<Injected>& injected) {
    Mjcf model = Drawn().Copy();
    EditModel(machine, injected, &model);
    model.SetTimestep_s(kTimestep_s);
    return {model.Compile(/*with_looks=*/false), /*hanging_n=*/0};
  }
};

TEST_P(EveryFrameAct, PutsTheTipWhereTheClosedFormSays) {
  const Machine machine = Gantry();
  const Vec3<double> probe_off_mm(5, 30, -10);
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    const std::vector<Injected> injected = Large(axis, machine);
    World world = WorldWith(machine, injected);
    world.MoveTool_mm(probe_off_mm);

    for (const Vec3<double>& q_mm :
         {Vec3<double>(0, 300, 20), {150, 150, 60}, {290, 10, 110}, {70, 220, 5}}) {
      const At at{
          .kind = RowKind::kPosition, .q_mm = q_mm, .probe_off_mm = probe_off_mm};
      const Vec3<double> tip_mm =
          at.Tip_mm() + ErrorsAt<double>(machine, at, injected).motion_mm;

      world.Place(q_mm, q_mm, Vec3<double>::Zero(), Vec3<double>::Zero());
      EXPECT_LT((world.Tip_mm() - tip_mm).norm(), kPlaced_mm) << axis;
      for (int i = 0; i < 20; ++i) world.Step(q_mm);
      EXPECT_LT((world.Tip_mm() - tip_mm).norm(), kHeld_mm) << axis;
    }
  }
}

TEST_P(EveryFrameAct, KeepsTheTipThereWhileItMoves) {
  const Machine machine = Gantry();
  const Vec3<double> feed_mm_s(10, -10, 10);
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    const std::vector<Injected> injected = Large(axis, machine);
    World world = WorldWith(machine, injected);
    Vec3<double> q_mm(40, 250, 100);
    world.Place(q_mm, q_mm, feed_mm_s, feed_mm_s);

    double worst_mm = 0;
    for (int i = 0; i < 100; ++i) {
      q_mm += feed_mm_s * kTimestep_s;
      world.Step(q_mm);
      const At at{.kind = RowKind::kPosition, .q_mm = q_mm};
      const Vec3<double> tip_mm =
          q_mm + ErrorsAt<double>(machine, at, injected).motion_mm;
      worst_mm = std::max(worst_mm, (world.Tip_mm() - tip_mm).norm());
    }

    EXPECT_LT(worst_mm, kHeld_mm) << axis;
  }
}

std::vector<int> FrameActs() {
  std::vector<int> indices;
  for (const ActOf& act : AllActs()) {
    const bool is_frame = EffectAt(act.effect).stage == Stage::kFrame;
    if (is_frame && act.kind == ActKind::kEditModel) indices.push_back(act.effect);
  }
  return indices;
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryFrameAct,
                         ::testing::ValuesIn(FrameActs()),
                         [](const auto& test) {
                           return std::string(EffectAt(test.param).name);
                         });

INSTANTIATE_TEST_SUITE_P(,
                         EveryAct,
                         ::testing::Range(0, static_cast<int>(kNumEffects)),
                         [](const auto& test) {
                           return std::string(EffectAt(test.param).name);
                         });

TEST(Mjcf, TheGenericModelTakesTheSameDrawing) {
  Machine machine = Gantry();
  machine.model.clear();

  EXPECT_NE(ModelOf(machine).Compile(false), nullptr);
}

TEST(Mjcf, AModelWithoutTheNamesItNeedsIsRefusedWithAllOfThem) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "empty.xml";
  WriteTextFile(file, "<mujoco/>");

  try {
    Mjcf::FromFile(file);
    FAIL() << "an empty model was taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 21U);  // 9 joints, 3 of each of 3 kinds, 3 others.
  }
}

}  // namespace
}  // namespace caltwin
