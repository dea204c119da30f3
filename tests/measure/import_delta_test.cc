#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "sim/base/yaml.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/kinds/klipper_delta.h"
#include "sim/measure/import/klipper_mesh.h"
#include "tests/measure/import_bench.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kStep_mm = 0.0125;  // 40 mm in 200 * 16 steps.

DeltaModel<double> Saved() {
  DeltaModel<double> model = SymmetricDelta(300, 150, 315);
  model.angle_rad[0] += RadFromDeg(0.5);
  model.endstop_mm[1] += 0.25;
  return model;
}

/// A printer.cfg whose touches were taken at (x, y) at these heights by the saved
/// geometry, counts not rounded.
std::string PrinterCfgText(const std::vector<Vec3<double>>& poses_mm,
                           double height_mm,
                           const std::string& written = "") {
  const DeltaModel<double> model = Saved();
  std::string text = written.empty() ? "[printer]\nkinematics: delta\n"
                                       "[stepper_a]\nrotation_distance: 40\n"
                                       "microsteps: 16 # of a TMC\n"
                                       "[stepper_b]\nrotation_distance: 40\n"
                                       "microsteps: 16\n"
                                       "[stepper_c]\nrotation_distance: 40\n"
                                       "microsteps: 16\n"
                                     : written;
  text += "#*# <------ SAVE_CONFIG ------>\n#*#\n#*# [printer]\n";
  text += fmt::format("#*# delta_radius = {}\n", model.radius_mm[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format(
        "#*# [stepper_{}]\n#*# angle = {:.9f}\n#*# arm_length = {}\n"
        "#*# position_endstop = {}\n",
        TowerName(static_cast<int>(i)),
        DegFromRad(model.angle_rad[i]),
        model.arm_mm[i],
        model.endstop_mm[i]);
  }
  text += "#*# [delta_calibrate]\n";
  for (std::size_t i = 0; i < poses_mm.size(); ++i) {
    const Vec3<double> counts = DeltaMotors_mm(model, poses_mm[i]) / kStep_mm;
    text += fmt::format("#*# height{} = {}\n#*# height{}_pos = {:.6f},{:.6f},{:.6f}\n",
                        i,
                        height_mm,
                        i,
                        counts[0],
                        counts[1],
                        counts[2]);
  }
  return text;
}

const std::vector<Vec3<double>> kPoses_mm = {
    {0, 0, 16.1}, {0, 90, 16.2}, {-80, 40, 15.9}, {70, -50, 16}, {10, -95, 16.3}};

TEST(KlipperDelta, IsReadAsTouchesWhereTheSavedGeometryStood) {
  const Imported imported =
      ImportText("klipper-delta", PrinterCfgText(kPoses_mm, 16), "f.cfg", {});

  ASSERT_EQ(imported.table.rows.size(), kPoses_mm.size());
  for (std::size_t i = 0; i < kPoses_mm.size(); ++i) {
    const Row& row = imported.table.rows[i];
    const double rounding_mm = 1e-6;  // Angles and counts are written with six digits.
    EXPECT_NEAR(row.cmd_mm[0], kPoses_mm[i][0], rounding_mm);
    EXPECT_NEAR(row.cmd_mm[1], kPoses_mm[i][1], rounding_mm);
    EXPECT_EQ(row.cmd_mm[2], 0);
    EXPECT_NEAR(row.value_mm, kPoses_mm[i][2] - 16, rounding_mm);
    // Straight down by z, every carriage goes down by z.
    const Vec3<double> trigger_mm = DeltaMotors_mm(Saved(), kPoses_mm[i]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(row.motor_mm[static_cast<std::size_t>(k)],
                  trigger_mm[k] + kPoses_mm[i][2],
                  rounding_mm);
    }
    EXPECT_EQ(row.kind, RowKind::kTouch);
    EXPECT_EQ(row.feature, "bed.top");
  }
}

TEST(KlipperDelta, KeepsTheRawCountsThroughWritingAndReading) {
  const RowTable table = RowsOf("klipper-delta", PrinterCfgText(kPoses_mm, 16));

  ASSERT_THAT(table.extra_columns,
              ElementsAre("height_mm", "count_a", "count_b", "count_c"));
  const Vec3<double> counts = DeltaMotors_mm(Saved(), kPoses_mm[0]) / kStep_mm;
  EXPECT_EQ(table.rows[0].extra[1], fmt::format("{:.3f}", counts[0]));
}

TEST(KlipperDelta, BelievesWhatWasSavedBeforeWhatWasWritten) {
  const std::string written =
      "[printer]\nkinematics: delta\ndelta_radius: 99\n"
      "[stepper_a]\narm_length: 200\nstep_distance: 0.0125\n"
      "[stepper_b]\nstep_distance: 0.0125\n[stepper_c]\nstep_distance: 0.0125\n";

  const KlipperCalibration read =
      ReadKlipperCalibration(PrinterCfgText(kPoses_mm, 16, written), "f.cfg", {});

  EXPECT_EQ(read.geometry.model.radius_mm[0], 150);
  EXPECT_EQ(read.geometry.model.arm_mm[0], 315);
  EXPECT_EQ(read.geometry.drive[2].step_mm, 0.0125);
}

TEST(KlipperDelta, TakesArmsEndstopsAndAnglesThatAreInherited) {
  const std::string text =
      "[printer]\nkinematics: delta\ndelta_radius: 100\n"
      "[stepper_a]\narm_length: 200\nposition_endstop: 210\n"
      "#*# [delta_calibrate]\n#*# height0 = 0\n#*# height0_pos = 100,100,100\n";

  const KlipperCalibration read =
      ReadKlipperCalibration(text, "f.cfg", {.step_mm = 0.01});

  EXPECT_THAT(read.geometry.model.arm_mm, ElementsAre(200, 200, 200));
  EXPECT_THAT(read.geometry.model.endstop_mm, ElementsAre(210, 210, 210));
  EXPECT_DOUBLE_EQ(read.geometry.model.angle_rad[1], RadFromDeg(330.0));
}

TEST(KlipperDelta, CountsGearsAndFullStepsIntoAStep) {
  const std::string drive =
      "rotation_distance: 40\nmicrosteps: 32\nfull_steps_per_rotation: 400\n"
      "gear_ratio: 80:16, 3:2\n";
  const KlipperCalibration read = ReadKlipperCalibration(
      PrinterCfgText(kPoses_mm,
                     16,
                     "[printer]\nkinematics: delta\n[stepper_a]\n" + drive +
                         "[stepper_b]\n" + drive + "[stepper_c]\n" + drive),
      "f.cfg",
      {});

  EXPECT_DOUBLE_EQ(read.geometry.drive[1].step_mm, 40.0 / (400 * 32 * 7.5));
}

constexpr const char* kConfigG =
    "; a delta\n;M665 L1 R2 H3 ; as it was\n"
    "M665 L440.5:440.25:440 R235.1 H410 B185.0 X0.5 Y-0.25 Z0 ; calibrated\n"
    "M666 X-0.1 Y0.2 Z0.3 A0.05 B0\nM350 X16 Y16 Z16 I1\nM92 X80 Y80 Z80 E423\n";

// What an importer writes is a machine file that the rest of caltwin reads.
Machine MachineOf(const Imported& imported) {
  Faults faults;
  YamlMap map = ReadYamlText(imported.machine_yaml, "machine.yaml", &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

TEST(KlipperDelta, WritesAMachineThatIsReadAgain) {
  const Imported with_drives =
      ImportText("klipper-delta", PrinterCfgText(kPoses_mm, 16), "my printer.cfg", {});
  const Machine machine = MachineOf(with_drives);
  ASSERT_NE(machine.Own<DeltaDrawing>(), nullptr);
  EXPECT_DOUBLE_EQ(DeltaOf(machine).model.endstop_mm[1], 300.25);
  EXPECT_DOUBLE_EQ(machine.settings.steps_per_mm[2], 80);
  EXPECT_DOUBLE_EQ(machine.axes[0].lead_mm, 40);

  // A configuration without drives: steps as the firmware has them, belts as usual.
  const Machine rrf = MachineOf(ImportText("rrf-config", kConfigG, "config.g", {}));
  EXPECT_DOUBLE_EQ(DeltaOf(rrf).model.arm_mm[1], 440.25);
  EXPECT_DOUBLE_EQ(rrf.settings.steps_per_mm[0], 80);
}

// People change microsteps after DELTA_CALIBRATE and keep what was saved.
TEST(KlipperDelta, ReckonsCountsOfOtherMicrostepsWithTheirs) {
  std::string text = PrinterCfgText(kPoses_mm, 16);
  const Imported as_saved = ImportText("klipper-delta", text, "f.cfg", {});
  for (std::size_t at = 0;
       (at = text.find("microsteps: 16", at)) != std::string::npos;) {
    text.replace(at, 14, "microsteps: 64");
  }
  const Imported changed = ImportText("klipper-delta", text, "f.cfg", {});

  EXPECT_NEAR(changed.table.rows[1].value_mm, as_saved.table.rows[1].value_mm, 1e-9);
  EXPECT_THAT(as_saved.warnings, testing::IsEmpty());
  ASSERT_EQ(changed.warnings.size(), 1U);
  EXPECT_THAT(changed.warnings[0], HasSubstr("(16 in place of 64)"));
  EXPECT_THAT(changed.warnings[0], HasSubstr("lengths 4 times as short"));
}

TEST(KlipperDelta, WritesTheMachineThatItBelievesIn) {
  const Imported imported =
      ImportText("klipper-delta", PrinterCfgText(kPoses_mm, 16), "my printer.cfg", {});

  EXPECT_THAT(imported.machine_yaml,
              HasSubstr("\nname: my_printer\nkinematics: delta\n"));
  EXPECT_THAT(imported.machine_yaml,
              HasSubstr("towers:\n  a: {angle_deg: 210.500000}\n  b: {angle_deg: "
                        "330.000000}\n  c: {angle_deg: 90.000000}\n"
                        "delta_radius_mm: 150.000000\narm_length_mm: 315.000000\n"
                        "endstop_mm: {a: 300.000000, b: 300.250000, c: 300.000000}\n"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("steps_per_mm: {a: 80, b: 80, c: 80}"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("pulley_mm_per_rev: 40"));
}

TEST(KlipperDelta, RefusesWhatItCannotReadAndSaysWhere) {
  const std::string good = PrinterCfgText(kPoses_mm, 16);
  const auto with = [&](const std::string& old_text, const std::string& new_text) {
    std::string text = good;
    text.replace(text.find(old_text), old_text.size(), new_text);
    return ImportFault("klipper-delta", text);
  };

  EXPECT_THAT(with("height1_pos", "height1_gone"),
              HasSubstr("[delta_calibrate] height1_pos is missing"));
  EXPECT_THAT(with("height2 = 16", "height2 = nan"),
              HasSubstr("f:33:15: [delta_calibrate] height2 = 'nan' is no number"));
  EXPECT_THAT(with("delta_radius = 150", "delta_radius = 1e400"),
              HasSubstr("delta_radius = '1e400' is no number"));
  EXPECT_THAT(with("arm_length = 315", "arm_length = 149"),
              HasSubstr("an arm of 149 mm at a delta radius of 150 mm"));
  EXPECT_THAT(with("kinematics: delta", "kinematics: corexy"),
              HasSubstr("f:2:13: [printer] kinematics is 'corexy'"));
  EXPECT_THAT(with("rotation_distance: 40", "rotation_distance: 0"),
              HasSubstr("rotation_distance = '0' is no number"));
  EXPECT_THAT(with("#*# height0 = 16", "#*# height0 = -15.9"),
              HasSubstr("the probe would trigger below the bed"));
  EXPECT_THAT(ImportFault("klipper-delta", "[printer]\nkinematics: delta\n"),
              HasSubstr("no saved delta calibration stands here"));
}

TEST(KlipperDelta, AsksForAStepAndSaysWhichTheTouchesSuggest) {
  const std::string text = TestData("imports/delta_no_step.cfg");

  EXPECT_THAT(
      ImportFault("klipper-delta", text),
      HasSubstr("Give the step yourself with --step-mm: the touch nearest to the "
                "middle suggests 0.0125"));
  EXPECT_EQ(RowsOf("klipper-delta", text, {.step_mm = 0.0125}).rows.size(), 7);
}

TEST(KlipperDelta, ReadsAPrinterOfSomebodyElse) {
  const KlipperCalibration read =
      ReadKlipperCalibration(TestData("imports/delta_v400_distances.cfg"), "f.cfg", {});

  EXPECT_EQ(read.touches.size(), 7);
  EXPECT_EQ(read.distances.size(), 12);
  EXPECT_EQ(read.geometry.drive[0].step_mm, 0.0125);
  EXPECT_EQ(read.geometry.model.radius_mm[0], 162.769280);
}

constexpr const char* kRoundMesh =
    "[printer]\nkinematics: cartesian\n"
    "#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n"
    "#*# \t  0.2, 0.2, 0.2\n#*# \t  0.1, 0.0, -0.1\n#*# \t  0.3, 0.3, 0.3\n"
    "#*# x_count = 3\n#*# y_count = 3\n#*# min_x = -50\n#*# max_x = 50.01\n"
    "#*# min_y = -50\n#*# max_y = 50\n";

TEST(KlipperMesh, LeavesOutTheCornersThatAreCopies) {
  const RowTable table = RowsOf("klipper-mesh", kRoundMesh);

  ASSERT_EQ(table.rows.size(), 5);
  EXPECT_EQ(table.rows[0].value_mm, 0.2);
  EXPECT_NEAR(table.rows[0].cmd_mm[0], 0.005, 1e-12);
  EXPECT_EQ(table.rows[0].cmd_mm[1], -50);
  EXPECT_EQ(table.rows[3].value_mm, -0.1);
  EXPECT_EQ(table.rows[4].cmd_mm[1], 50);
}

TEST(KlipperMesh, KeepsCornersThatWereProbed) {
  const RowTable table = RowsOf("klipper-mesh", TestData("imports/mesh_trident.cfg"));

  ASSERT_EQ(table.rows.size(), 25);
  EXPECT_EQ(table.rows[0].value_mm, -0.030625);
  EXPECT_EQ(table.rows[0].cmd_mm[0], 25);
  EXPECT_EQ(table.rows[24].value_mm, 0.05);
  EXPECT_EQ(table.rows[24].cmd_mm[0], 225);
  EXPECT_FALSE(Known(table.rows[0].motor_mm[0]));
}

TEST(KlipperMesh, OfADeltaSaysWhereTheCarriagesAre) {
  const std::string text = TestData("imports/mesh_v400.cfg");

  const Imported imported = ImportText("klipper-mesh", text, "f.cfg", {});

  EXPECT_EQ(imported.table.rows.size(), 49);
  EXPECT_THAT(imported.recognised,
              ElementsAre(HasSubstr("32 beyond it are copies of their neighbours"),
                          HasSubstr("not among these rows")));
  const Row& row = imported.table.rows[24];
  const Vec3<double> nozzle_mm =
      DeltaNozzle_mm(ReadKlipperBed(text, "f.cfg").geometry->model,
                     {row.motor_mm[0], row.motor_mm[1], row.motor_mm[2]});
  EXPECT_NEAR(
      (nozzle_mm - Vec3<double>(row.cmd_mm[0], row.cmd_mm[1], 0)).norm(), 0, 1e-9);
}

TEST(KlipperMesh, ReadsEveryMeshOfAFileAsACampaign) {
  const Imported imported = ImportText(
      "klipper-mesh", TestData("imports/delta_super_racer.cfg"), "f.cfg", {});

  EXPECT_EQ(imported.table.rows.size(), 98);
  EXPECT_EQ(imported.table.rows.front().campaign, "mesh_80_bed");
  EXPECT_EQ(imported.table.rows.back().campaign, "mesh_default");
}

TEST(KlipperMesh, RefusesPointsThatAreNotAllThere) {
  const auto with = [](const std::string& old_text, const std::string& new_text) {
    std::string text = kRoundMesh;
    text.replace(text.find(old_text), old_text.size(), new_text);
    return ImportFault("klipper-mesh", text);
  };

  EXPECT_THAT(
      with("0.1, 0.0, -0.1", "0.1, -0.1"),
      HasSubstr("f:7:8: [bed_mesh default] this line has 2 points, x_count is 3"));
  EXPECT_THAT(with("0.1, 0.0", "0.1, inf"),
              HasSubstr("f:7:13: [bed_mesh default] points, number 2 = 'inf'"));
  EXPECT_THAT(with("y_count = 3", "y_count = 4"),
              HasSubstr("has 3 lines of points, y_count is 4"));
  EXPECT_THAT(with("x_count = 3", "x_count = 1e9"),
              HasSubstr("is no number from 2 to 100"));
  EXPECT_THAT(with("max_x = 50.01", "max_x = -50"),
              HasSubstr("less than a millimetre wide"));
  EXPECT_THAT(ImportFault("klipper-mesh", "[printer]\n"),
              HasSubstr("no mesh stands here"));
}

TEST(RrfConfig, BecomesAMachineOfThreeTowers) {
  const Imported imported = ImportText("rrf-config", kConfigG, "config.g", {});

  EXPECT_TRUE(imported.table.rows.empty());
  EXPECT_THAT(imported.machine_yaml, HasSubstr("a: {angle_deg: 210.500000}"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("b: {angle_deg: 329.750000}"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("delta_radius_mm: 235.100000"));
  EXPECT_THAT(
      imported.machine_yaml,
      HasSubstr("arm_length_mm: {a: 440.500000, b: 440.250000, c: 440.000000}"));
  EXPECT_THAT(imported.machine_yaml,
              HasSubstr("endstop_mm: {a: 409.900000, b: 410.200000, c: 410.300000}"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("steps_per_mm: {a: 80, b: 80, c: 80}"));
  EXPECT_THAT(imported.warnings, ElementsAre(HasSubstr("M666 A0.05 B0")));
}

TEST(RrfConfig, RefusesWhatIsNoDelta) {
  EXPECT_THAT(ImportFault("rrf-config", "M92 X80 Y80\n"),
              HasSubstr("no machine among them"));
  EXPECT_THAT(ImportFault("rrf-config", "M665 L440 R441 H400\n"),
              HasSubstr("f:1:12: arms of 440 mm at a delta radius of 441 mm"));
  EXPECT_THAT(ImportFault("rrf-config", "M665 L440:1 R100 H400\n"),
              HasSubstr("f:1:7: M665 L has 2 arms"));
  EXPECT_THAT(ImportFault("rrf-config", "M665 L440 Rnan H400\n"),
              HasSubstr("M665 R = 'nan' is not a finite number"));
  EXPECT_THAT(ImportFault("rrf-config", "M665 L440 R100\n"),
              HasSubstr("M665 has no H: the homed height"));
}

TEST(RrfHeightmap, TellsABareNoughtFromAProbedOne) {
  const RowTable table =
      RowsOf("rrf-heightmap",
             "RepRapFirmware height map file v2 generated at 2021-04-30 19:13\n"
             "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n"
             "-50.00,50.10,-25.00,25.10,60.00,50.00,50.00,3,2\n"
             "      0, -0.049,      0\n  0.000,  0.046,  0.020\n");

  ASSERT_EQ(table.rows.size(), 4);
  EXPECT_EQ(table.rows[0].value_mm, -0.049);
  EXPECT_THAT(table.rows[0].cmd_mm, ElementsAre(0, -25, 0));
  EXPECT_EQ(table.rows[1].value_mm, 0);
  EXPECT_THAT(table.rows[1].cmd_mm, ElementsAre(-50, 25, 0));
}

TEST(RrfHeightmap, RefusesATableThatIsCutOff) {
  const std::string head =
      "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n"
      "0,50,0,50,60,50,50,2,2\n";

  EXPECT_THAT(ImportFault("rrf-heightmap", head + "0.1,0.2\n"),
              HasSubstr("1 lines of heights, not 2"));
  EXPECT_THAT(ImportFault("rrf-heightmap", head + "0.1,0.2\n0.1\n"),
              HasSubstr("f:4:1: 1 heights in a line, not 2"));
  EXPECT_THAT(ImportFault("rrf-heightmap", head + "0.1,0.2\n0.1,x\n"),
              HasSubstr("f:4:5: a height = 'x'"));
  EXPECT_THAT(ImportFault("rrf-heightmap", "hello\n"),
              HasSubstr("no height map stands here"));
}

}  // namespace
}  // namespace caltwin
