#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "sim/measure/climate.h"
#include "sim/measure/import/growth_fit.h"
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
  const GrowthFit fit = PlainGrowth(table);

  const double rounding_um = 5e-3;  // Temperatures here are rounded to 0.001 K.
  EXPECT_EQ(table.rows.size(), 1203U);
  EXPECT_NEAR(UmFromMm(fit.frame_mm_per_k), -33.354, rounding_um);
  EXPECT_NEAR(UmFromMm(fit.bed_mm_per_k), 2.003, rounding_um);
  EXPECT_NEAR(UmFromMm(fit.rms_mm), 4.837, rounding_um);
}

// A part that lags behind its thermometer: what hours left out are foretold by.
TEST(ImportThermal, LagsForetellHoursThatWereLeftOut) {
  const RowTable table = ImportText("klipper-thermal", GoodLog(), "f", {}).table;
  const GrowthFit plain = PlainGrowth(table);
  const GrowthFit lagged = LaggedGrowth(table);

  EXPECT_GT(lagged.frame_lag_s, 60);
  EXPECT_LT(lagged.rms_mm, 0.8 * plain.rms_mm);
  EXPECT_LT(lagged.held_out_rms_mm, 0.9 * plain.held_out_rms_mm);
  EXPECT_GT(lagged.held_out_rms_mm, lagged.rms_mm);
}

// dT = 20 (1 - exp(-t / 1000)) at the thermometers, felt 300 s and 0 s later.
TEST(ImportThermal, LagsOfRowsMadeWithThemAreFound) {
  RowTable table;
  TemperatureLog frame;
  for (int i = 0; i < 200; ++i) {
    const double t_s = 40.0 * i;
    Row row{.t_s = t_s, .temp_frame_c = 20 + 20 * (1 - std::exp(-t_s / 1000))};
    row.temp_bed_c = i < 100 ? 20 + 0.5 * i : 70;
    frame.Add(t_s, row.temp_frame_c);
    table.rows.push_back(row);
  }
  for (Row& row : table.rows) {
    row.value_mm = 1 - 0.030 * frame.Lagged_k(row.t_s, 300.0) +
                   0.002 * (row.temp_bed_c - table.rows[0].temp_bed_c);
  }
  const GrowthFit fit = LaggedGrowth(table);

  EXPECT_NEAR(fit.frame_mm_per_k, -0.030, 2e-4);
  EXPECT_NEAR(fit.bed_mm_per_k, 0.002, 2e-5);
  EXPECT_NEAR(fit.frame_lag_s, 300, 60);  // The grid of lags has steps of a third.
  EXPECT_LT(fit.rms_mm, 0.3e-3);
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
  EXPECT_THAT(imported.recognised[2], HasSubstr("-33.35 um per kelvin"));
  EXPECT_THAT(imported.recognised[3],
              HasSubstr("without lag: -33.35 um/K frame, 2.00 um/K bed, rms 4.84 um"));
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
