// What may be changed in a compiled world, and how it is placed: compared with
// geometry by hand.
#include "sim/physics/world.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

constexpr double kRounding_mm = 1e-9;
constexpr double kFar_mm = 1000;
const Vec3<double> kStill = Vec3<double>::Zero();

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

Mjcf GantryModel() {
  static const Mjcf kModel = [] {
    Mjcf model = ModelOf(Gantry());
    model.AddSolid("table_to_touch", TableOf(Gantry()));
    model.SetTimestep_s(2e-4);
    return model;
  }();
  return kModel.Copy();
}

World WorldOf(const Mjcf& model) {
  return {model.Compile(/*with_looks=*/false), /*hanging_n=*/0};
}

void StandAt(const Vec3<double>& q_mm, World* world) {
  world->Place(q_mm, q_mm, kStill, kStill);
}

// The nuts move by `travel_mm` in that many steps, then rest as long.
void Move(const Vec3<double>& travel_mm, int num_steps, World* world) {
  const Vec3<double> from_mm = world->Nuts_mm();
  for (int i = 1; i <= 2 * num_steps; ++i) {
    world->Step(from_mm + travel_mm * std::min(1.0, 1.0 * i / num_steps));
  }
}

TEST(World, AMovedToolStandsAsFarFromItsPlaceAndTouchesThere) {
  World world = WorldOf(GantryModel());
  StandAt({100, 120, 10}, &world);

  world.MoveTool_mm({0.3, 40, -0.5});

  EXPECT_LT((world.Tip_mm() - Vec3<double>(100.3, 160, 9.5)).norm(), kRounding_mm);
  EXPECT_NEAR(world.Clearance_mm(kFar_mm), 9.5 - 1, kRounding_mm);
}

TEST(World, ATableSetToASlopeIsNearerByHeightAndSlopeAboutItsPoint) {
  World world = WorldOf(GantryModel());
  const double slope_x = 0.002;
  const double slope_y = -0.001;
  const Vec3<double> about_mm(150, 150, 0);

  world.SetTable(about_mm, 0.1, slope_x, slope_y);

  for (const Vec3<double>& q_mm : {Vec3<double>(100, 120, 10), {250, 40, 5}}) {
    StandAt(q_mm, &world);
    const double height_mm = q_mm[2] - 0.1 - slope_x * (q_mm[0] - about_mm[0]) -
                             slope_y * (q_mm[1] - about_mm[1]);
    const double across = 1 / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
    EXPECT_NEAR(world.Clearance_mm(kFar_mm), height_mm * across - 1, kRounding_mm);
  }
}

TEST(World, ATableSetBackStandsAsModelled) {
  Mjcf model = GantryModel();
  model.TiltTable(0.003, 0.001, {150, 150, 0});
  World world = WorldOf(model);
  StandAt({60, 220, 10}, &world);
  const double before_mm = world.Clearance_mm(kFar_mm);

  world.SetTable({10, 20, 0}, 0.2, 0.004, 0.002);
  const double moved_mm = world.Clearance_mm(kFar_mm);
  world.SetTable({10, 20, 0}, 0, 0, 0);

  EXPECT_GT(std::abs(moved_mm - before_mm), 0.1);
  EXPECT_NEAR(world.Clearance_mm(kFar_mm), before_mm, kRounding_mm);
}

TEST(World, AStylusIsBentByATableThatIsRaisedIntoIt) {
  World world = WorldOf(GantryModel());
  StandAt({100, 120, 1.02}, &world);
  Move(kStill, 100, &world);
  EXPECT_LT(world.Deflection_mm().norm(), 1e-6);

  world.SetTable({100, 120, 0}, 0.05, 0, 0);
  Move(kStill, 400, &world);

  // 2e-5: PHYSICS.md's contact under the stylus' 0.5 N.
  EXPECT_NEAR(world.Deflection_mm()[2], 0.03, 2e-5);
}

TEST(World, AGapOpenedWhileItRunsLosesItsWidthAtAReversalAndClosesAgain) {
  World world = WorldOf(GantryModel());
  StandAt({100, 100, 50}, &world);
  EXPECT_EQ(world.Gap_mm(Axis::kX), 0);

  world.SetGap_mm(Axis::kX, 0.06);
  EXPECT_NEAR(world.Gap_mm(Axis::kX), 0.06, kRounding_mm);
  Move({0.1, 0, 0}, 1500, &world);
  const double forward_mm = world.Carriages_mm()[0] - world.Nuts_mm()[0];
  Move({-0.1, 0, 0}, 1500, &world);
  const double backward_mm = world.Carriages_mm()[0] - world.Nuts_mm()[0];
  world.SetGap_mm(Axis::kX, 0);
  Move({-0.1, 0, 0}, 1500, &world);

  // Stopped from 1/3 mm/s against 8 N, 6 kg coast by m v^2 / (2 F).
  const double held_mm = 6 * (1e-3 / 3) * (1.0 / 3) / (2 * 8) + 1e-5;
  EXPECT_NEAR(forward_mm, -0.03, held_mm);
  EXPECT_NEAR(backward_mm, +0.03, held_mm);
  EXPECT_NEAR(world.Carriages_mm()[0] - world.Nuts_mm()[0], 0, held_mm);
  EXPECT_EQ(world.Gap_mm(Axis::kX), 0);
}

TEST(World, AGapBeyondASpringWidensItsDeadBand) {
  Mjcf model = GantryModel();
  model.SetGap(Axis::kY, 0.02);
  model.SetDriveStiffness(Axis::kY, 2000);
  World world = WorldOf(model);
  EXPECT_NEAR(world.Gap_mm(Axis::kY), 0.02, kRounding_mm);

  world.SetGap_mm(Axis::kY, 0.05);

  EXPECT_NEAR(world.Gap_mm(Axis::kY), 0.05, kRounding_mm);
}

// The gantry's model with a person's own words in it: each first one replaced.
Mjcf EditedModel(const std::vector<std::pair<std::string, std::string>>& edits) {
  std::string text = ReadTextFile("models/gantry_router/model.xml", 1 << 20);
  for (const auto& [before, after] : edits) {
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    text.replace(at, before.size(), after);
  }
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "edited_by_hand.xml";
  WriteTextFile(file, text);
  Mjcf model = Mjcf::FromFile(file);
  ApplyDrawing(Gantry(), &model);
  model.SetTimestep_s(2e-4);
  return model;
}

TEST(World, AJointThatAPersonTiedToAnAxisIsPlacedWhereItBelongs) {
  // dz = 0.4 mm (x - 0.15 m)^2 / (0.15 m)^2, as a polynomial of x.
  const std::string rail =
      R"(<joint name="x" class="rail" axis="1 0 0" frictionloss="8"/>)";
  const Mjcf model =
      EditedModel({{rail, rail + R"(<joint name="dip" type="slide" axis="0 0 1"/>)"},
                   {"<equality>",
                    R"(<equality><joint joint1="dip" joint2="x"
           polycoef="4e-4 -5.333333333333333e-3 1.7777777777777778e-2 0 0"/>)"}});
  World world = WorldOf(model);

  for (const double x_mm : {0.0, 60.0, 150.0, 300.0}) {
    StandAt({x_mm, 100, 50}, &world);
    const double dip_mm = 0.4 * std::pow((x_mm - 150) / 150, 2);
    EXPECT_NEAR(world.Tip_mm()[2], 50 + dip_mm, kRounding_mm) << x_mm;
    Move(kStill, 50, &world);
    EXPECT_NEAR(world.Tip_mm()[2], 50 + dip_mm, 1e-6) << x_mm;
  }
}

TEST(World, AGeomThatAPersonPutOnTheTableIsTouched) {
  Mjcf model = EditedModel({{R"(<body name="table">)",
                             R"(<body name="table">
        <geom type="box" pos=".1 .12 .001" size=".02 .02 .001" contype="2"/>)"}});
  model.AddSolid("table_to_touch", TableOf(Gantry()));
  World world = WorldOf(model);

  StandAt({100, 120, 10}, &world);
  EXPECT_NEAR(world.Clearance_mm(kFar_mm), 10 - 2 - 1, kRounding_mm);
  StandAt({100, 180, 10}, &world);
  EXPECT_NEAR(world.Clearance_mm(kFar_mm), 10 - 1, kRounding_mm);
}

TEST(World, AGapThatAPersonWroteIntoTheModelIsKnown) {
  const Mjcf model = EditedModel(
      {{R"(<fixed name="y_play">)", R"(<fixed name="y_play" range="-2e-5 2e-5">)"},
       {R"(<tendon name="y_rigid")", R"(<tendon name="y_rigid" active="false")"}});

  EXPECT_NEAR(WorldOf(model).Gap_mm(Axis::kY), 0.04, kRounding_mm);
  EXPECT_EQ(WorldOf(model).Gap_mm(Axis::kX), 0);
}

TEST(World, ACarriageIsPlacedByTheModelsOwnCoupling) {
  World world = WorldOf(EditedModel({{R"(<joint joint="x_nut" coef="-1"/>)",
                                      R"(<joint joint="x_nut" coef="-1.002"/>)"}}));

  StandAt({200, 100, 50}, &world);

  EXPECT_NEAR(world.Tip_mm()[0], 200.4, kRounding_mm);
  Move({1, 0, 0}, 500, &world);
  EXPECT_NEAR(world.Tip_mm()[0], 201.402, 1e-6);
}

}  // namespace
}  // namespace caltwin
