#include "renders/kinds/z_station_scene.h"

#include <gtest/gtest.h>

#include "renders/kinds/still.h"

namespace caltwin {
namespace {

// Where a body of the scene stands now [mm].
double Height_mm(const mjModel* model, const mjData* data, const char* body) {
  const int id = mj_name2id(model, mjOBJ_BODY, body);
  EXPECT_GT(id, 0) << body;
  return 1e3 * data->xpos[3 * id + 2];
}

// Heights over one another as the drawing has them, what stands off it so many times.
TEST(ZStationScene, PartsStandOffTheirDrawingEnlarged) {
  const ZStationDrawing drawing{.switch_mm = 1.5, .body_mm = 6.5, .trigger_mm = 0.5};
  const ZStationBuild build{.tip_mm = -0.1,
                            .body_mm = -6.4,
                            .trigger_mm = 0.55,
                            .switch_mm = 1.7,
                            .surface_mm = 0.05};
  for (const double times : {0.0, 1.0, 20.0}) {
    const ZStationScene scene(drawing, build, times);
    const auto at_mm = [&](const char* body) {
      return Height_mm(scene.model(), scene.data(), body);
    };
    const double head_mm = at_mm("head");
    EXPECT_NEAR(at_mm("nozzle") - head_mm, -0.1 * times, 1e-9);
    EXPECT_NEAR(at_mm("probe") - head_mm, -6.5 + 0.1 * times, 1e-9);
    // Pin and knob stand out by the 0.3 mm that they go in until they trigger.
    EXPECT_NEAR(at_mm("knob") - at_mm("probe"), -0.8 - 0.05 * times, 1e-9);
    EXPECT_NEAR(at_mm("pin"), 1.8 + 0.2 * times, 1e-9);
    EXPECT_NEAR(at_mm("plate"), 0.05 * times, 1e-9);
  }
}

TEST(ZStationScene, ABedLeansWithItsSlopesWithinReason) {
  for (const auto& [slope_x, drawn] : {std::pair{0.001, 0.05}, std::pair{0.1, 0.2}}) {
    const ZStationScene scene({}, {.slope_x = slope_x}, /*exaggerate=*/50);
    const int plate = mj_name2id(scene.model(), mjOBJ_BODY, "plate");
    const double* const turned = scene.data()->xmat + 9 * plate;
    EXPECT_NEAR(turned[6] / turned[0], drawn, 1e-9);  // z over x, along its own x.
  }
}

// A scenario's station stands on whatever machine it names, a machine file's alone.
TEST(ZStationScene, IsOfScenariosAndOfMachines) {
  const std::filesystem::path root(CALTWIN_SOURCE_DIR);
  const Still of_scenario =
      StillOf(root / "scenarios/z_offset_after_nozzle_and_plate_change.yaml", 1);
  const Still of_machine = StillOf(root / "models/z_station/machine.yaml", 1);

  EXPECT_EQ(of_scenario.model->nbody, of_machine.model->nbody);
  EXPECT_NEAR(Height_mm(of_machine.model, of_machine.data, "pin"), 1.8, 1e-9);
  EXPECT_FALSE(of_machine.move_to) << "what it touches is told as heights only";
}

}  // namespace
}  // namespace caltwin
