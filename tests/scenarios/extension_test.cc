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

// What the two tables say together is what the one written says, between knots too.
TEST(Extension, TwoTablesOfOneNameAreWrittenAsTheirSum) {
  Finding other = Table();
  other.map->knots = {{-50, 100, 250}, {25, 100}};
  other.map->values_um = {10, -20, 5, 7, -3, 12};

  const MachineFile read =
      ReadMachineFile(Extended("twice.ext.yaml", "gantry_router", {Table(), other}));

  const auto effects = DrawEffects(read.effects, 1, 0);
  ASSERT_THAT(effects, SizeIs(1));
  const MapWords words = WordsOf("z{x,t}");
  const auto value = [&](const std::vector<double>& flat, double x_mm, double t_s) {
    At at{.t_s = t_s};
    at.q_mm.x() = x_mm;
    return MapValue<double>(flat, words, at);
  };
  const auto one = FlatMap(Table().map->values_um, Table().map->knots);
  const auto two = FlatMap(other.map->values_um, other.map->knots);
  for (const double x_mm : {-80.0, -20.0, 40.0, 130.0, 280.0, 320.0}) {
    for (const double t_s : {-10.0, 10.0, 40.0, 70.0, 130.0}) {
      EXPECT_NEAR(value(effects[0].values, x_mm, t_s),
                  value(one, x_mm, t_s) + value(two, x_mm, t_s),
                  1e-6)
          << x_mm << " " << t_s;
    }
  }
}

TEST(Extension, OneNameTwiceWithoutATableIsReadBack) {
  Finding none = Table();
  none.map->knots.clear();

  EXPECT_THAT(
      ReadMachineFile(Extended("none.ext.yaml", "gantry_router", {none, none})).effects,
      IsEmpty());
  EXPECT_THAT(
      ReadMachineFile(Extended("wave.ext.yaml", "gantry_router", {Wave(), Wave()}))
          .effects,
      SizeIs(1));
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
