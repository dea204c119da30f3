#include "sim/machine/machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StrEq;

constexpr const char* kSmallest =
    "kinematics: cartesian\n"
    "axes:\n"
    "  x: {max_mm: 300, lead_mm: 4}\n"
    "  y: {max_mm: 200, lead_mm: 4}\n"
    "  z: {max_mm: 100, lead_mm: 2}\n";

Machine Read(const std::string& text) {
  Faults faults;
  YamlMap map = ReadYamlText(text, "m.yaml", &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

std::string MessagesOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Machine, TravelAndLeadAreEnough) {
  const Machine machine = Read(kSmallest);

  EXPECT_EQ(machine.name, "m");
  EXPECT_EQ(machine.axis(Axis::kY).travel_mm(), 200);
  EXPECT_EQ(machine.axis(Axis::kX).home, HomeEnd::kMin);
  EXPECT_EQ(machine.axis(Axis::kZ).home, HomeEnd::kMax);
  // 200 full steps of 16 microsteps over a lead of 4 mm, and of 2 mm.
  EXPECT_THAT(machine.settings.steps_per_mm, ElementsAre(800, 800, 1600));
  EXPECT_THAT(machine.settings.backlash_mm, ElementsAre(0, 0, 0));
  EXPECT_EQ(machine.settings.tip_radius_mm, machine.probe.tip_radius_mm);
}

TEST(Machine, SettingsLieOverTheDrawing) {
  const Machine machine =
      Read(std::string(kSmallest) +
           "probe: {tip_radius_mm: 1.5}\n"
           "settings: {steps_per_mm: {x: 808}, backlash_mm: {z: 0.03}}\n");

  EXPECT_THAT(machine.settings.steps_per_mm, ElementsAre(808, 800, 1600));
  EXPECT_THAT(machine.settings.backlash_mm, ElementsAre(0, 0, 0.03));
  EXPECT_EQ(machine.settings.tip_radius_mm, 1.5);
}

TEST(Machine, ABeltHasAPulleyInPlaceOfALead) {
  const Machine machine =
      Read(Replaced(kSmallest, "300, lead_mm: 4", "300, pulley_mm_per_rev: 40"));

  EXPECT_TRUE(machine.axis(Axis::kX).is_belt);
  EXPECT_FALSE(machine.axis(Axis::kY).is_belt);
  EXPECT_EQ(machine.settings.steps_per_mm[0], 80);
  EXPECT_THAT(
      MessagesOf(Replaced(kSmallest, "lead_mm: 4", "lead_mm: 4, pulley_mm_per_rev: 4")),
      StrEq("m.yaml:3:6: axes.x has both lead_mm and pulley_mm_per_rev\n"
            "  a screw has a lead, a belt a pulley: keep one"));
}

TEST(Machine, EveryFaultIsReportedAtOnce) {
  EXPECT_THAT(MessagesOf("kinematics: cartesion\n"
                         "axes:\n"
                         "  x: {max_mm: 300, lead_mm: 4}\n"
                         "  y: {min_mm: 9, max_mm: 9, lead_mm: 0}\n"
                         "  z: {max_mm: 100, led_mm: 4}\n"),
              StrEq("m.yaml:1:13: kinematics = 'cartesion' is not known\n"
                    "  did you mean 'cartesian'? It may be: cartesian, delta, "
                    "triple_z, z_station, motor_stage, corexy\n"
                    "m.yaml:4:6: axes.y: max_mm = 9 is not above min_mm = 9\n"
                    "m.yaml:4:38: axes.y.lead_mm = 0 is outside 0.001 .. 10000\n"
                    "  travel per motor turn\n"
                    "m.yaml:5:20: axes.z has no key 'led_mm'\n"
                    "  did you mean 'lead_mm'? It knows: acceleration_mm_s2, "
                    "counterbalance_n, full_steps_per_rev, home, lead_mm, "
                    "max_feed_mm_s, max_mm, microsteps, min_mm, moving_mass_kg, "
                    "pulley_mm_per_rev, rail_friction_n"));
}

TEST(Machine, AMissingAxisIsMissed) {
  EXPECT_THAT(MessagesOf("kinematics: cartesian\naxes:\n"
                         "  y: {max_mm: 300, lead_mm: 4}\n"
                         "  z: {max_mm: 300, lead_mm: 4}\n"),
              StrEq("m.yaml:3:3: axes lacks the key 'x'"));
}

TEST(Machine, OnlyTheVerticalAxisHasACounterbalance) {
  EXPECT_THAT(
      MessagesOf(Replaced(kSmallest, "lead_mm: 4", "lead_mm: 4, counterbalance_n: 9")),
      HasSubstr("m.yaml:3:32: axes.x has no key 'counterbalance_n'"));
}

TEST(Machine, TheProbeReleasesBeforeItsRest) {
  EXPECT_THAT(MessagesOf(std::string(kSmallest) +
                         "probe: {pretravel_mm: 0.01, hysteresis_mm: 0.01}\n"),
              StrEq("m.yaml:6:8: probe: hysteresis_mm is not below pretravel_mm\n"
                    "  the switch must release before the stylus is back at rest"));
}

TEST(Machine, AModelThatIsNotThereIsAFault) {
  EXPECT_THAT(MessagesOf(std::string(kSmallest) + "model: none.xml\n"),
              StrEq("m.yaml:6:8: model = 'none.xml': there is no such file\n"
                    "  a path is relative to the machine file"));
}

TEST(Machine, TheGantryRouterThatComesAlongIsReadable) {
  const Machine machine = ReadMachine(FindMachine("gantry_router", ".", {}));

  EXPECT_EQ(machine.name, "gantry_router");
  EXPECT_THAT(machine.settings.steps_per_mm, ElementsAre(800, 800, 800));
}

TEST(FindMachine, SaysWhereItLooked) {
  try {
    FindMachine("gantry_rooter", ".", {.file = "s.yaml", .line = 2, .column = 10});
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("s.yaml:2:10: there is no machine 'gantry_rooter'\n"
                          "  looked for models/gantry_rooter/machine.yaml and "));
  }
}

TEST(FindMachine, APathIsRelativeToTheFileThatNamesIt) {
  const std::string models = std::string(CALTWIN_SOURCE_DIR) + "/models";

  EXPECT_EQ(FindMachine("gantry_router/machine.yaml", models, {}),
            models + "/gantry_router/machine.yaml");
  EXPECT_EQ(FindMachine("./gantry_router", models, {}),
            models + "/./gantry_router/machine.yaml");
  EXPECT_THROW(FindMachine("none/machine.yaml", models, {}), InputError);
}

TEST(WeightKeepsGapShut, WhereMoreHangsThanTheRailHolds) {
  AxisDrawing z{.moving_mass_kg = 2.5, .rail_friction_n = 5};
  const double weight_n = 2.5 * kGravity_m_s2;

  z.counterbalance_n = weight_n;
  EXPECT_FALSE(WeightKeepsGapShut(Axis::kZ, z));
  z.counterbalance_n = weight_n - 4.9;
  EXPECT_FALSE(WeightKeepsGapShut(Axis::kZ, z));
  z.counterbalance_n = weight_n - 5.1;
  EXPECT_TRUE(WeightKeepsGapShut(Axis::kZ, z));
  z.counterbalance_n = weight_n + 5.1;  // Pulled up: shut too, on the other side.
  EXPECT_TRUE(WeightKeepsGapShut(Axis::kZ, z));
  EXPECT_FALSE(WeightKeepsGapShut(Axis::kX, z));
}

TEST(Axis, NamesAndIndexesAgree) {
  EXPECT_EQ(AxisNamed("y"), Axis::kY);
  EXPECT_EQ(AxisNamed("Y"), std::nullopt);
  EXPECT_EQ(AxisNamed("xy"), std::nullopt);
  EXPECT_EQ(AxisNamed(""), std::nullopt);
  for (const Axis axis : kAxes) EXPECT_EQ(AxisNamed(Name(axis)), axis);
  EXPECT_EQ(Unit(Axis::kZ), Vec3<double>(0, 0, 1));
}

}  // namespace
}  // namespace caltwin
