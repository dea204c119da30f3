#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renders/kinds/motor_stage_scene.h"
#include "renders/kinds/still.h"
#include "renders/machine_scene.h"
#include "renders/pose_grid.h"
#include "renders/run_pictures.h"
#include "renders/scene.h"
#include "renders/scene_json.h"
#include "sim/base/text_file.h"
#include "sim/effects/catalog.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

TwinConfig Router() {
  const Machine machine = ReadMachine(std::filesystem::path(CALTWIN_SOURCE_DIR) /
                                      "models/gantry_router/machine.yaml");
  return {.machine = machine,
          .settings = machine.settings,
          .artefacts = {{.id = "block", .at_mm = {150, 150, 0}}}};
}

PictureOptions Small(const std::string& camera = "") {
  return {.width = 320, .height = 240, .camera = camera};
}

std::size_t NumColours(const Picture& picture) {
  std::set<std::array<std::uint8_t, 3>> colours;
  for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3) {
    colours.insert({picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]});
  }
  return colours.size();
}

/// Pixels that are clearly red: of the router, the probe's ruby ball alone is (its
/// accents are orange: their green is more than a quarter of their red).
int NumRubyPixels(const Picture& picture) {
  int count = 0;
  for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3) {
    const int red = picture.rgb[i], green = picture.rgb[i + 1];
    if (red > 110 && green < red / 5) ++count;
  }
  return count;
}

TEST(Scene, DrawsTheMachineAndNotAnEmptySheet) {
  const Picture picture = MachinePicture(Router(), 1, Small());

  EXPECT_EQ(picture.width, 320);
  EXPECT_EQ(picture.height, 240);
  EXPECT_GT(NumColours(picture), 100);
}

TEST(Scene, GivesTheSameBytesTwice) {
  EXPECT_EQ(PngBytes(MachinePicture(Router(), 1, Small())),
            PngBytes(MachinePicture(Router(), 1, Small())));
}

TEST(Scene, ShowsTheTipThroughTheProbesCamera) {
  EXPECT_GT(NumRubyPixels(MachinePicture(Router(), 1, Small("probe"))), 3);
}

TEST(Scene, StandsUpright) {
  // The room is light above the machine, the machine's frame dark at the bottom's
  // middle.
  const Picture picture = MachinePicture(Router(), 1, Small("front"));
  const auto brightness = [&](int row, int column) {
    const std::size_t at = 3 * (static_cast<std::size_t>(row) * 320 + column);
    return picture.rgb[at] + picture.rgb[at + 1] + picture.rgb[at + 2];
  };

  EXPECT_GT(brightness(2, 20), 450);
  EXPECT_LT(brightness(187, 160), 200);
}

/// First and last column in which two pictures differ.
std::array<int, 2> ChangedColumns(const Picture& a, const Picture& b) {
  std::array<int, 2> columns = {a.width, -1};
  for (int i = 0; i < a.width * a.height; ++i) {
    if (std::equal(&a.rgb[3 * i], &a.rgb[3 * i] + 3, &b.rgb[3 * i])) continue;
    columns = {std::min(columns[0], i % a.width), std::max(columns[1], i % a.width)};
  }
  return columns;
}

TEST(Scene, DrawsAnArrowFromItsStartToItsEnd) {
  MachineScene scene(Router());
  scene.MoveTo({150, 300, 120});
  PictureOptions options = Small("table");
  options.shadows = false;
  const Picture bare = DrawScene(scene.model(), scene.data(), options);
  options.arrows = {{.from_mm = {20, 20, 5}, .to_mm = {220, 20, 5}}};
  const Picture with_arrow = DrawScene(scene.model(), scene.data(), options);
  options.arrows.clear();
  options.markers = {{.at_mm = {20, 20, 5}}, {.at_mm = {220, 20, 5}}};

  const Picture with_ends = DrawScene(scene.model(), scene.data(), options);

  const std::array<int, 2> arrow = ChangedColumns(bare, with_arrow);
  const std::array<int, 2> ends = ChangedColumns(bare, with_ends);
  // The balls stand out at both ends, and the head tapers to less than a pixel.
  const double neglected = 0.1 * (ends[1] - ends[0]);
  EXPECT_NEAR(arrow[0], ends[0], neglected);
  EXPECT_NEAR(arrow[1], ends[1], neglected);
}

TEST(Scene, ShowsTheBlock) {
  TwinConfig bare = Router();
  bare.artefacts.clear();
  MachineScene with(Router()), without(bare);
  const Vec3<double> pose_mm(150, 300, 120);
  with.MoveTo(pose_mm);
  without.MoveTo(pose_mm);

  EXPECT_NE(DrawScene(with.model(), with.data(), Small("table")).rgb,
            DrawScene(without.model(), without.data(), Small("table")).rgb);
}

TEST(Scene, OfAMachineWithoutAModelShowsTheGenericOne) {
  TwinConfig config = Router();
  config.machine.model.clear();

  EXPECT_GT(NumColours(MachinePicture(config, 1, Small())), 20);
}

TEST(MotorStageScene, ShowsEachCarriageBesideItsRail) {
  const MotorStageDrawing drawing =
      MotorStageOf(ReadMachine(CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml"));
  BuiltMotorStage built{.drawing = drawing};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    built.motors[i].drawing = drawing.axes[i];
  }
  const MotorStageScene scene(built, /*exaggerate=*/1);
  const Picture before = DrawScene(scene.model(), scene.data(), Small());
  built.faults[0].start_unit += 50;
  const MotorStageScene moved(built, /*exaggerate=*/1);

  EXPECT_GT(NumColours(before), 100);
  EXPECT_NE(before.rgb, DrawScene(moved.model(), moved.data(), Small()).rgb);
}

TEST(MachineScene, PutsTheTipWhereTheMotorsAre) {
  MachineScene scene(Router());

  scene.MoveTo({100, 50, 30});

  const int tip = mj_name2id(scene.model(), mjOBJ_GEOM, "tip");
  const double* at_m = scene.data()->geom_xpos + 3 * tip;
  EXPECT_NEAR(at_m[0], 0.100, 1e-12);
  EXPECT_NEAR(at_m[1], 0.050, 1e-12);
  EXPECT_NEAR(at_m[2], 0.030, 1e-12);
}

Injected Gap(double gap_mm) {
  return {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {gap_mm}};
}

TEST(Exaggerated, ScalesGeometricErrorsAlone) {
  const Machine machine = Router().machine;
  const std::vector<Injected> effects = {
      Gap(0.05),
      {.effect = EffectIndex<ProbePretravel>(), .axis = "x", .values = {0.03}},
      {.effect = EffectIndex<BedTilt>(), .values = {1.0, -2.0}}};

  const std::vector<Injected> larger = Exaggerated(machine, effects, 10);

  EXPECT_DOUBLE_EQ(larger[0].values[0], 0.5);
  EXPECT_EQ(larger[1].values, effects[1].values);
  EXPECT_DOUBLE_EQ(larger[2].values[0], 10);
  EXPECT_DOUBLE_EQ(larger[2].values[1], -20);
}

TEST(Exaggerated, ByZeroIsTheDrawing) {
  TwinConfig tilted = Router();
  tilted.effects = {{.effect = EffectIndex<BedTilt>(), .values = {3.0, 3.0}}};

  EXPECT_EQ(MachinePicture(tilted, 0, Small()).rgb,
            MachinePicture(Router(), 0, Small()).rgb);
}

TEST(GridErrors, OfAGapAreHalfOfItEachWay) {
  TwinConfig config = Router();
  config.effects = {Gap(0.08)};

  for (const PoseError& error : GridErrors(config, config.settings)) {
    EXPECT_NEAR(error.error_mm.x(), error.is_forward ? -0.04 : 0.04, 1e-9);
    EXPECT_NEAR(error.error_mm.y(), 0, 1e-9);
  }
}

TEST(GridErrors, VanishWithTheRightSteps) {
  TwinConfig config = Router();
  Settings wrong = config.settings;
  wrong.steps_per_mm[0] = 808;

  // 1 % of 300 mm, the mean removed: 1.5 mm at either end.
  EXPECT_EQ(Magnification(GridErrors(config, wrong)), 20);
  EXPECT_TRUE(ArrowsOf(GridErrors(config, config.settings), 1000).empty());
}

TEST(Magnification, IsARoundNumber) {
  const auto of = [](double error_mm) {
    return Magnification({{.error_mm = {error_mm, 0, 0}}});
  };

  EXPECT_DOUBLE_EQ(of(0.04), 1000);
  EXPECT_DOUBLE_EQ(of(0.05), 500);
  EXPECT_DOUBLE_EQ(of(0.15), 200);
  EXPECT_DOUBLE_EQ(of(0), 1);
}

TEST(SceneJson, HasTheRodsOfADelta) {
  const Still delta = StillOf(
      std::filesystem::path(CALTWIN_SOURCE_DIR) / "models/delta_printer/machine.yaml",
      /*exaggerate=*/1);

  const auto rods = SceneJson(delta)["rods"];

  ASSERT_EQ(rods.size(), 6);
  for (const auto& rod : rods) {
    Vec3<double> ends_mm[2];
    for (std::size_t i = 0; i < 2; ++i) {
      const int body = rod["bodies"][i];
      const auto at_mm = rod["ends_mm"][i].get<std::vector<double>>();
      const BodyPose pose = PosesOf(*delta.data, {body}).front();
      const Eigen::Quaterniond turned(pose[3], pose[4], pose[5], pose[6]);
      ends_mm[i] = Vec3<double>(pose[0], pose[1], pose[2]) +
                   turned * Vec3<double>(at_mm[0], at_mm[1], at_mm[2]);
    }
    EXPECT_NEAR((ends_mm[1] - ends_mm[0]).norm(), 250, 1e-3);
  }
}

TEST(StillOfATwin, HasItsHiddenErrorsEnlargedAndItsArtefacts) {
  const std::filesystem::path root(CALTWIN_SOURCE_DIR);
  const TwinFiles twin{.machine = root / "models/gantry_router/machine.yaml",
                       .truth = root / "examples/practice/gantry_router.yaml",
                       .artefacts = Router().artefacts};
  TwinFiles bare = twin;
  bare.artefacts.clear();
  // Carriages trail by half their gap.
  const auto trails_mm = [&](const TwinFiles& files, double exaggerate) {
    const Still still = StillOf(files, exaggerate);
    still.move_to({100, 100, 20});
    double most_mm = 0;
    for (int i = 0; i < still.model->nq; ++i) {
      const double off_mm = std::abs(still.data->qpos[i]) * 1000;
      for (const double at_mm : {100.0, 20.0}) {
        const double trail_mm = std::abs(off_mm - at_mm);
        most_mm = std::max(most_mm, trail_mm < 5 ? trail_mm : 0.0);
      }
    }
    return most_mm;
  };

  EXPECT_EQ(StillOf(twin, 1).model->ngeom, StillOf(bare, 1).model->ngeom + 1);
  EXPECT_NEAR(trails_mm(twin, 1), 0.031, 1e-6);
  EXPECT_NEAR(trails_mm(twin, 100), 3.1, 1e-4);
  EXPECT_NEAR(trails_mm({.machine = twin.machine}, 100), 0, 1e-6);
}

TEST(StillOfATwin, TakesEachKindsTruth) {
  const std::filesystem::path models =
      std::filesystem::path(CALTWIN_SOURCE_DIR) / "models";
  for (const auto& [name, truth] :
       {std::pair{"delta_printer", "effects:\n  bed_tilt: {slope_x_mrad: 4}\n"},
        std::pair{"triple_z_printer", "effects:\n  bed_tilt: {slope_x_mrad: 4}\n"},
        std::pair{"motor_stage", "effects:\n  backlash.x: {gap_mm: 0.4}\n"}}) {
    const TempFolder folder;
    const std::filesystem::path file = folder.path() / "truth.yaml";
    std::ofstream(file) << truth;
    const TwinFiles drawn{.machine = models / name / "machine.yaml"};
    TwinFiles built = drawn;
    built.truth = file;

    const auto poses = [](const TwinFiles& files, double exaggerate) {
      const Still still = StillOf(files, exaggerate);
      std::vector<int> all(static_cast<std::size_t>(still.model->nbody));
      std::iota(all.begin(), all.end(), 0);
      return PosesOf(*still.data, all);
    };

    EXPECT_GT(Apart_mm(poses(built, 1), poses(drawn, 1)), 1e-3) << name;
    EXPECT_GT(Apart_mm(poses(built, 10), poses(drawn, 1)),
              5 * Apart_mm(poses(built, 1), poses(drawn, 1)))
        << name;
  }
}

TEST(RunPictures, ShowTheMachineAndItsErrorsBeforeAndAfter) {
  RunResult result{.scenario = "scenarios/first_light.yaml", .fidelity = "fast"};
  result.verbatim = ReadTextFile(result.scenario, 1 << 20);
  result.settings_before = result.settings_after = Router().settings;
  result.settings_before.steps_per_mm[0] = 808;

  const ReportPictures pictures = PicturesOf(result);

  ASSERT_EQ(pictures.pictures.size(), 4);
  EXPECT_EQ(pictures.pictures[1].title, "Before.");
  EXPECT_EQ(pictures.pictures[3].title, "What is left.");
  EXPECT_NE(pictures.pictures[1].png, pictures.pictures[2].png);
  for (const ReportPicture& picture : pictures.pictures) {
    EXPECT_TRUE(picture.png.starts_with("\x89PNG"));
  }
}

}  // namespace
}  // namespace caltwin
