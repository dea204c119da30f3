#include <cmath>

#include <Eigen/Dense>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "sim/measure/import/klipper_thermal.h"
#include "tests/measure/import_bench.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::string& GoodLog() {
  static const std::string text = TestData("imports/frame_log_2021-06-13_05-41.csv");
  return text;
}

// The figures of tests/data/imports/README.md, by numpy over the source's numbers.
TEST(ImportThermal, FrameAndBedCoefficientsAreTheCertifiedOnes) {
  const RowTable table = ImportText("klipper-thermal", GoodLog(), "f", {}).table;
  const auto count = static_cast<Eigen::Index>(table.rows.size());
  Eigen::MatrixX3d terms(count, 3);
  Eigen::VectorXd values_um(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Row& row = table.rows[static_cast<std::size_t>(i)];
    terms.row(i) << row.temp_frame_c, row.temp_bed_c, 1;
    values_um[i] = UmFromMm(row.value_mm);
  }
  const Eigen::Vector3d fit =
      (terms.transpose() * terms).ldlt().solve(terms.transpose() * values_um);
  const double rms_um = (values_um - terms * fit).norm() / std::sqrt(count);

  const double rounding = 5e-3;  // Temperatures here are rounded to 0.001 K.
  EXPECT_EQ(count, 1203);
  EXPECT_NEAR(fit[0], -33.354, rounding);
  EXPECT_NEAR(fit[1], 2.003, rounding);
  EXPECT_NEAR(rms_um, 4.837, rounding);
}

TEST(ImportThermal, AFrameLogBecomesTouchesOfOnePlace) {
  const Imported imported = ImportText("klipper-thermal", GoodLog(), "f", {});
  const Row& second = imported.table.rows[1];

  EXPECT_EQ(second.kind, RowKind::kTouch);
  EXPECT_EQ(second.t_s, 4);                       // 05:42:16 to 05:42:20.
  EXPECT_DOUBLE_EQ(second.value_mm, 4 * 0.0025);  // -89869 to -89865.
  EXPECT_EQ(second.temp_bed_c, 26.032);
  EXPECT_EQ(second.n[2], 1);
  EXPECT_EQ(second.dir[2], -1);
  EXPECT_EQ(imported.header.instruments.at("probe").resolution_um, 2.5);
  EXPECT_EQ(imported.header.settings.at("s1").steps_per_mm.at("z"), 400);
  EXPECT_THAT(imported.warnings, IsEmpty());
  EXPECT_THAT(imported.recognised.back(), HasSubstr("-33.35 um per kelvin"));
}

// 0.0125 mm is the step before the 80:16 gears: five times too long.
TEST(ImportThermal, AStepFiveTimesTooLongIsCaught) {
  const std::string text = TestData("imports/frame_log_2021-06-13_20-04.csv");
  const std::string fault = ImportFault("klipper-thermal", text);

  EXPECT_THAT(fault, HasSubstr("f:3:1: a step of 0.0125 mm makes the trigger height"));
  EXPECT_THAT(fault, HasSubstr("a voron_v2_350 moves a fifth of it, 0.0025"));
  const Imported cured = ImportText("klipper-thermal", text, "f", {.step_mm = 0.0025});
  EXPECT_THAT(cured.warnings, IsEmpty());
  // Said by the person it is kept, loudly.
  const Imported insisted =
      ImportText("klipper-thermal", text, "f", {.step_mm = 0.0125});
  EXPECT_THAT(insisted.warnings[0], HasSubstr("a step of 0.0125 mm makes"));
}

TEST(ImportThermal, AnyLogScaledByFiveIsCaughtAndTheTrueOneNever) {
  const Imported good = ImportText("klipper-thermal", GoodLog(), "f", {});
  FrameLogHeader header{.step_mm = 0.0025, .frame_length_mm = 530};
  const GrowthPerKelvin growth = GrowthOf(good.table, header);
  RowTable scaled = good.table;
  for (Row& row : scaled.rows) row.value_mm *= 5;

  EXPECT_LT(growth.ratio, 3);
  EXPECT_THAT(StepFault(growth, header), IsEmpty());
  EXPECT_THAT(StepFault(GrowthOf(scaled, header), header),
              HasSubstr("would have to grow"));
}

TEST(ImportThermal, WithoutAStepItIsAskedAndHomingFaultsAreTold) {
  const std::string text = TestData("imports/frame_log_2021-06-05_13-24.csv");

  EXPECT_THAT(
      ImportFault("klipper-thermal", text),
      HasSubstr("f:2:13: mcu_pos_z counts motor steps, and nothing here says how "
                "long one is\n  say it: --step-mm"));
  const Imported imported =
      ImportText("klipper-thermal", text, "f", {.step_mm = 0.0025});
  ASSERT_THAT(imported.warnings, SizeIs(1));
  EXPECT_THAT(imported.warnings[0], HasSubstr("more than 1 mm from the median"));
  EXPECT_THAT(imported.table.rows, SizeIs(129));  // Kept.
}

TEST(ImportThermal, ProbeDriftTakesTemperaturesBetweenItsRecords) {
  const std::string text =
      "{\"ts\":100.0,\"btemp\":20.0,\"etemp\":30.0,\"atherms\":[{\"id\":\"C\","
      "\"temp\":25.0}]}\n{\"ts\":105.0,\"z\":0.01}\n{\"ts\":110.0,\"btemp\":30.0,"
      "\"etemp\":30.0,\"atherms\":[]}\n{\"ts\":120.0,\"z\":-0.02}\n";
  const RowTable table = RowsOf("klipper-thermal", text);

  ASSERT_THAT(table.rows, SizeIs(2));
  EXPECT_DOUBLE_EQ(table.rows[0].temp_bed_c, 25);
  EXPECT_EQ(table.rows[1].t_s, 15);
  EXPECT_EQ(table.rows[1].temp_bed_c, 30);
  EXPECT_FALSE(Known(table.rows[1].temp_chamber_c));
  EXPECT_EQ(table.rows[1].value_mm, -0.02);
}

TEST(ImportThermal, ARealProbeDriftLogIsRead) {
  const Imported imported =
      ImportText("klipper-thermal", TestData("imports/probe_drift.json"), "f", {});

  EXPECT_THAT(imported.table.rows, SizeIs(50));
  EXPECT_DOUBLE_EQ(imported.header.instruments.at("probe").resolution_um, 1.25);
  EXPECT_EQ(imported.table.rows[0].value_mm, -0.00375);
  EXPECT_NEAR(imported.table.rows[0].temp_chamber_c, 27.6, 0.1);
}

TEST(ImportThermal, WhatIsNoLogIsExplained) {
  EXPECT_THAT(
      ImportFault("klipper-thermal", "{\"ts\":1,\"z\":nan}\n"),
      HasSubstr("f:1:1: this line is no record of a probe drift log\n  a record"));
  EXPECT_THAT(ImportFault("klipper-thermal", "{\"ts\":1}\n"),
              HasSubstr("has neither z nor a temperature"));
  EXPECT_THAT(ImportFault("klipper-thermal", "Prusa\nGeneral Stats vs Window:\n"),
              HasSubstr("f:2:1: this is a summary: means and ranges, no readings"));
  EXPECT_THAT(ImportFault("klipper-thermal", "a,b\n1,2\n"),
              HasSubstr("f:1:1: the column 'time' is missing"));
  EXPECT_THAT(ImportFault("klipper-thermal",
                          "# step_dist=-1\ntime,mcu_pos_z,frame_t\n20:00:00,1,20\n"),
              HasSubstr("step_dist = '-1' is no length of a step"));
  EXPECT_THAT(ImportFault("klipper-thermal",
                          "# step_dist=0.01\ntime,mcu_pos_z,frame_t\nnoon,1,20\n"),
              HasSubstr("f:3:1: time = 'noon' is no time"));
}

}  // namespace
}  // namespace caltwin
