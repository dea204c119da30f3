#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/foretold_mesh.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/klipper_mesh.h"
#include "tests/calibration/delta_engine_rows.h"

namespace caltwin {
namespace {

using delta_rows::Believed;
using delta_rows::Built;
using ::testing::HasSubstr;

DeltaBuild<double> UnlikeRods() {
  DeltaBuild<double> build = Built();
  build.rod_error_mm = {0.2, -0.1, -0.25, 0.1, 0.05, 0.3};
  return build;
}

// As if everything about the machine were known.
DeltaJointFit Known(const DeltaBuild<double>& build) {
  return {.build = build};
}

TEST(DeltaMesh, IsBilinearBetweenItsNodes) {
  const DeltaMesh mesh{.radius_mm = 10, .nodes = 2, .height_mm = {0, 1, 2, 5}};

  EXPECT_DOUBLE_EQ(mesh.Lift_mm(-10, -10), 0);
  EXPECT_DOUBLE_EQ(mesh.Lift_mm(10, -10), 1);
  EXPECT_DOUBLE_EQ(mesh.Lift_mm(-10, 10), 2);
  EXPECT_DOUBLE_EQ(mesh.Lift_mm(0, 0), 2);
  EXPECT_DOUBLE_EQ(mesh.Lift_mm(30, 30), 5);  // As at the rim.
  EXPECT_EQ(DeltaMesh{}.Lift_mm(3, 4), 0);
}

// What no settings of three rods can hold is gone where the machine is known: left is
// what bends between the nodes.
TEST(ForetoldMesh, TakesAwayWhatSettingsLeave) {
  const DeltaBuild<double> build = UnlikeRods();
  const DeltaModel<double> settings =
      BestDeltaSettings(build, {}, Believed(), 100, {.has_radius_per_tower = false});
  const double without_mm = DeltaAccuracyOf(build, {}, settings, 100).z_rms_mm;
  const auto left_mm = [&](int nodes) {
    const DeltaMesh mesh = ForetoldMesh(Known(build), settings, 100, nodes);
    return DeltaAccuracyOf(build, {}, settings, 100, mesh).z_rms_mm;
  };

  EXPECT_GT(without_mm, 0.003);
  EXPECT_LT(left_mm(7), without_mm / 4);
  // Half a cell bends a quarter, but at the rim, whose nodes beyond stand in for
  // others.
  EXPECT_LT(left_mm(13), left_mm(7) / 2);
}

TEST(ForetoldMesh, IsReadAgainAsKlipperWouldReadIt) {
  const DeltaMesh mesh = ForetoldMesh(Known(UnlikeRods()), Believed(), 100, 7);
  const KlipperBed bed = ReadKlipperBed(MeshAsKlipper(mesh), "printer.cfg");

  ASSERT_EQ(bed.meshes.size(), 1U);
  for (const MeshPoint& point : bed.meshes[0].points) {
    EXPECT_NEAR(point.z_mm, mesh.Lift_mm(point.x_mm, point.y_mm), 1e-6);
  }
}

TEST(ForetoldMesh, IsWrittenNodeByNodeForMarlin) {
  const DeltaMesh mesh{.radius_mm = 100, .nodes = 2, .height_mm = {0.1, 0.2, 0.3, 0.4}};

  EXPECT_EQ(MeshAsMarlin(mesh),
            "M421 I0 J0 Z0.1000\nM421 I1 J0 Z0.2000\nM421 I0 J1 Z0.3000\n"
            "M421 I1 J1 Z0.4000\nM420 S1\n");
}

}  // namespace
}  // namespace caltwin
