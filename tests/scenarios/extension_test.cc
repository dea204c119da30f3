#include "calibration/diagnosis/extension.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/machine_file.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"
#include "sim/effects/catalog.h"
#include "sim/effects/map_table.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kMost_bytes = 100'000;

Finding Wave() {
  return {.cause = "cyclic_lead",
          .axis = "x",
          .probability = 0.998,
          .log_odds = 41.5,
          .candidates = {{"cyclic_lead", "x", 0.998, false},
                         {"pulley_eccentric", "x", 0.002, false}},
          .covariates = {"x"},
          .effect = Injected{.effect = EffectIndex<CyclicLead>(),
                             .axis = "x",
                             .values = {5.6, 40, 4.001}},
          .sds = {0.2, 3, 0.001}};
}

Finding Table() {
  return {.cause = "unknown",
          .axis = "z",
          .probability = 0.97,
          .log_odds = 12,
          .candidates = {{"unknown", "z", 0.97, false}},
          .covariates = {"x", "t"},
          .map = FreeMap{.channel = "z",
                         .covariates = {"x", "t"},
                         .knots = {{0, 300}, {0, 50, 100}},
                         .values_um = {1, 2, 3, 4, 5, 6}}};
}

fs::path Extended(const std::string& name,
                  const std::string& base,
                  const std::vector<Finding>& findings) {
  const fs::path file = fs::path(::testing::TempDir()) / name;
  const fs::path base_file = FindMachine(base, file.parent_path(), {});
  WriteTextFile(
      file,
      ExtensionText({.findings = findings},
                    {.extends = base,
                     .extends_sha256 = Sha256(ReadTextFile(base_file, kMost_bytes)),
                     .data_sha256 = Sha256("rows")}));
  return file;
}

TEST(Extension, IsReadBackAsTheEffectsFound) {
  const fs::path file = Extended("both.ext.yaml", "gantry_router", {Wave(), Table()});

  const MachineFile read = ReadMachineFile(file);

  const auto effects = DrawEffects(read.effects, 1, 0);
  ASSERT_THAT(effects, SizeIs(2));
  EXPECT_EQ(effects[0].effect, EffectIndex<CyclicLead>());
  EXPECT_THAT(effects[0].values, ElementsAre(5.6, 40, 4.001));
  EXPECT_EQ(effects[1].axis, "z{x,t}");
  EXPECT_EQ(effects[1].values, FlatMap({1, 2, 3, 4, 5, 6}, {{0, 300}, {0, 50, 100}}));
  EXPECT_THAT(read.notes, IsEmpty()) << "the base is the one that was extended";
}

TEST(Extension, OfAnExtensionKeepsTheEarlierEffects) {
  Extended("first.ext.yaml", "gantry_router", {Wave()});

  const MachineFile read =
      ReadMachineFile(Extended("second.ext.yaml", "first.ext.yaml", {Table()}));

  EXPECT_THAT(read.effects, SizeIs(2));
}

TEST(Extension, SaysOfEachCauseHowSureItIsAndWhatElseItCouldBe) {
  const YAML::Node written = YAML::Load(ExtensionText({.findings = {Wave()}}, {}));

  const YAML::Node wave = written["effects"]["cyclic_lead.x"];
  EXPECT_EQ(wave["sd"]["amplitude_um"].as<double>(), 0.2);
  EXPECT_EQ(wave["probability"].as<double>(), 0.998);
  EXPECT_EQ(wave["rivals"][0].as<std::string>(), "pulley_eccentric.x");
  EXPECT_EQ(written["evidence"]["log_odds"]["cyclic_lead.x{x}"].as<double>(0), 0);
  EXPECT_EQ(written["evidence"]["log_odds"]["cyclic_lead.x"].as<double>(), 41.5);
}

}  // namespace
}  // namespace caltwin
