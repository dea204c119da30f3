#include "scenarios/machine_file.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StrEq;

fs::path Written(const std::string& name, const std::string& text) {
  const fs::path file = fs::path(::testing::TempDir()) / name;
  WriteTextFile(file, text);
  return file;
}

TEST(MachineFile, AnExtensionIsTheMachineWithItsFoundEffects) {
  const fs::path file = Written("found.ext.yaml", R"(
extends: gantry_router
effects:
  backlash.x: {gap_mm: 0.05, sd: {gap_mm: 0.001}, probability: 0.99, rivals: []}
evidence: {data_sha256: 11, log_odds: 12.5}
)");

  const MachineFile read = ReadMachineFile(file);

  EXPECT_THAT(read.machine.axis(Axis::kX).lead_mm, DoubleEq(4));
  ASSERT_THAT(read.effects, SizeIs(1));
  EXPECT_THAT(read.effects[0].effect, Eq(EffectIndex<Backlash>()));
  EXPECT_THAT(Middle(read.effects[0].values[0]), DoubleEq(0.05));
  EXPECT_THAT(read.notes, IsEmpty());
}

TEST(MachineFile, TablesOfUnknownStructureAct) {
  const fs::path file = Written("odd.ext.yaml", R"(
extends: gantry_router
unknown:
  - {channel: z, covariates: [x, y], knots: [[0, 100], [0, 200]], values: [0, 4, 0, 8]}
)");

  const auto effects = DrawEffects(ReadMachineFile(file).effects, 1, 0);

  ASSERT_THAT(effects, SizeIs(1));
  const At at{.q_mm = {50, 100, 0}};
  EXPECT_THAT(ErrorsAt<double>(Machine{}, at, effects).motion_mm[2], DoubleEq(3e-3));
}

TEST(MachineFile, ATableWithAWordThatIsNoCovariateSaysWhichThereAre) {
  const fs::path file = Written("odd_word.ext.yaml", R"(
extends: gantry_router
unknown:
  - {channel: z, covariates: [q], knots: [0, 100], values: [0, 4]}
)");

  try {
    ReadMachineFile(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(FaultsText(error),
                AllOf(HasSubstr(file.string() + ":4:"),
                      HasSubstr("unknown[0].covariates[0] is no covariate"),
                      HasSubstr("since_rev feed load theta")));
  }
}

TEST(MachineFile, AnExtensionOfAFileThatHasChangedSaysSo) {
  const fs::path file =
      Written("changed.ext.yaml", "extends: gantry_router\nextends_sha256: \"00\"\n");

  EXPECT_THAT(ReadMachineFile(file).notes,
              ElementsAre(HasSubstr("has changed since it was extended")));
}

TEST(MachineFile, AnExtensionWithAMisspeltEffectSaysWhere) {
  const fs::path file = Written(
      "bad.ext.yaml", "extends: gantry_router\neffects:\n  backlas.x: {gap_mm: 1}\n");

  try {
    ReadMachineFile(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(FaultsText(error),
                StrEq(file.string() +
                      ":3:14: effects.backlas.x is no effect that this version can "
                      "inject\n  did you mean 'backlash.x'? `caltwin explain` lists "
                      "them all\n"));
  }
}

TEST(TruthFile, IsEffectsAndSettingsAndNothingElse) {
  const Machine machine = ReadMachineFile("models/gantry_router/machine.yaml").machine;
  const fs::path file = Written(
      "truth.yaml",
      "effects: {backlash.y: {gap_mm: 0.1}}\nsettings: {backlash_mm: {y: 0.02}}\n");

  const TruthFile truth = ReadTruthFile(file, machine);

  ASSERT_THAT(truth.effects, SizeIs(1));
  const Settings settings = DrawSettings(machine.settings, truth.settings, 1, 0);
  EXPECT_THAT(settings.backlash_mm, ElementsAre(0, 0.02, 0));
  EXPECT_THROW(ReadTruthFile(Written("more.yaml", "effects: {}\nseed: 1\n"), machine),
               InputError);
}

TEST(Settings, AreDrawnFromStreamsOfTheirOwn) {
  Faults faults;
  YamlMap alone =
      ReadYamlText("steps_per_mm: {y: {normal: {mean: 800, sd: 8}}}", "a", &faults);
  YamlMap together = ReadYamlText(
      "steps_per_mm: {x: {normal: {mean: 800, sd: 8}}, y: {normal: {mean: 800, sd: "
      "8}}}",
      "b",
      &faults);
  const auto spec_alone = ReadSettingSpecs(alone);
  const auto spec_together = ReadSettingSpecs(together);
  faults.ThrowIfAny();

  const Settings one = DrawSettings({}, spec_alone, 5, 0);
  const Settings two = DrawSettings({}, spec_together, 5, 0);

  EXPECT_THAT(one.steps_per_mm[1], DoubleEq(two.steps_per_mm[1]));
  EXPECT_NE(two.steps_per_mm[0], two.steps_per_mm[1]);
  EXPECT_NE(one.steps_per_mm[1], DrawSettings({}, spec_alone, 6, 0).steps_per_mm[1]);
}

}  // namespace
}  // namespace caltwin
