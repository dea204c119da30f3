#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/effects/acts/acts.h"
#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

class EveryAct : public ::testing::TestWithParam<int> {};

TEST_P(EveryAct, StandsAtItsEffectsPlaceInTheCatalog) {
  const ActOf& act = AllActs()[static_cast<std::size_t>(GetParam())];

  EXPECT_EQ(act.effect, GetParam());
  EXPECT_EQ(act.kind == ActKind::kEditModel, act.edit != nullptr);
}

TEST_P(EveryAct, AtItsNeutralValuesLeavesTheModelUntouched) {
  const Machine machine = Gantry();
  const std::string before = ModelOf(machine).ToText();
  for (const std::string_view axis : EffectAt(GetParam()).axes) {
    Mjcf model = ModelOf(machine);

    EditModel(machine, std::vector{NeutralEffect(GetParam(), axis, machine)}, &model);

    EXPECT_EQ(model.ToText(), before) << axis;
  }
}

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
