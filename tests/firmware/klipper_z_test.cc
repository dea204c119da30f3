#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/firmware/kinds/z_station/klipper.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Heights as told, no scatter.
class Heights : public ZStationPlant {
 public:
  std::optional<double> Touch(ZTouch touch, const Eigen::Vector2d& at_mm) override {
    last_at_mm = at_mm;
    return touch == ZTouch::kNozzleOnSwitch ? nozzle
           : touch == ZTouch::kBodyOnSwitch ? body
                                            : bed + slope.dot(at_mm);
  }
  void Heat(char, double) override {}
  double nozzle = 1.5, body = 8, bed = 8.7;
  Eigen::Vector2d slope{0, 0}, last_at_mm{0, 0};
};

class KlipperZTest : public ::testing::Test {
 protected:
  ZCalibrationConfig Config() {
    return {.position_endstop_mm = -0.3,
            .switch_offset_mm = 0.675,
            .before_switch_gcode = "ATTACH_PROBE",
            .end_gcode = "DETACH_PROBE"};
  }
  Heights heights_;
};

// The published formula and its first example.
TEST(ZCalibrationOffset, IsThatOfThePublishedExamples) {
  EXPECT_NEAR(ZCalibrationOffset_mm(-0.3, 6.208, 7.013, 0.675), -0.170, 1e-9);
  EXPECT_NEAR(ZCalibrationOffset_mm(-0.267, 2.370, 3.093, 0.466), -0.010, 1e-9);
}

TEST_F(KlipperZTest, CalibratesAsTheExtensionPrintsIt) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");

  const Reply reply = klipper.Execute("CALIBRATE_Z");

  // 6.9 - (6.2 + 0.3 + 0.675)
  EXPECT_THAT(reply.lines,
              ElementsAre("Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.300 SWITCH=6.200 "
                          "PROBE=6.900 --> OFFSET=-0.275000"));
  EXPECT_THAT(klipper.Execute("GET_POSITION").lines[3], HasSubstr("Z:-0.275000"));
}

TEST_F(KlipperZTest, ResetsAPreviousOffsetFirst) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("SET_GCODE_OFFSET Z=1.5");
  klipper.Execute("CALIBRATE_Z");
  klipper.Execute("CALIBRATE_Z");

  EXPECT_NEAR(*klipper.CarriageAtNought_mm({117.5, 117.5}), 1.8 - 0.275, 1e-9);
}

TEST_F(KlipperZTest, AdjustsAnOffsetAndMoves) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("G0 Z5");
  klipper.Execute("SET_GCODE_OFFSET Z_ADJUST=0.05 MOVE=1");

  const auto lines = klipper.Execute("GET_POSITION").lines;
  EXPECT_THAT(lines[1], HasSubstr("Z:5.050000"));
  EXPECT_THAT(lines[2], HasSubstr("Z:5.050000"));  // As Klipper: its base included.
  EXPECT_THAT(lines[3], HasSubstr("Z:0.050000"));
}

TEST_F(KlipperZTest, ReadsWordsAsKlipperDoes) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("g28 z");
  klipper.Execute("SET_GCODE_OFFSET Z=0.5 Z_ADJUST=0.1");

  EXPECT_THAT(klipper.Execute("GET_POSITION").lines[3], HasSubstr("Z:0.500000"));
  for (const char* line : {"SET_GCODE_OFFSET Z=nan",
                           "SET_GCODE_OFFSET Z=abc",
                           "PROBE_Z_ACCURACY PROBE_SPEED=abc",
                           "M104 Sfoo"}) {
    EXPECT_THAT(klipper.Execute(line).lines.back(), HasSubstr("unable to parse"))
        << line;
  }
}

TEST_F(KlipperZTest, MovesByAsMuchAfterG91) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("SET_GCODE_OFFSET Z=0.5");
  klipper.Execute("G1 X50 Y60 Z10");
  klipper.Execute("G91");
  klipper.Execute("G1X5Z-2F600");
  klipper.Execute("G90");

  EXPECT_THAT(klipper.Execute("M114").lines,
              ElementsAre("X:55.000 Y:60.000 Z:8.000 E:0.000"));
}

// A macro that probes twice has to lift in between, as at a printer.
TEST_F(KlipperZTest, PROBEEndsOnTheBed) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("ATTACH_PROBE");
  EXPECT_THAT(klipper.Execute("PROBE").lines, ElementsAre("Result is z=6.900000"));
  EXPECT_THAT(klipper.Execute("GET_POSITION").lines[1], HasSubstr("Z:6.900000"));

  for (const char* line : {"PROBE", "PROBE_ACCURACY"}) {
    EXPECT_TRUE(klipper.Execute(line).error) << line;
  }
  klipper.Execute("G1 Z15");
  EXPECT_FALSE(klipper.Execute("PROBE").error);
}

TEST_F(KlipperZTest, RefusesWhatKlipperRefuses) {
  KlipperZ klipper(Config(), &heights_);
  EXPECT_TRUE(klipper.Execute("SET_GCODE_OFFSET Z=0.1 MOVE=1").error);
  klipper.Execute("G28");

  EXPECT_THAT(klipper.Execute("G1 X50 F0").lines,
              ElementsAre("!! Invalid speed in 'G1 X50 F0'"));
  EXPECT_TRUE(klipper.Execute("SET_GCODE_OFFSET X=1").error);
  klipper.Execute("G1 Z20 Z30");
  EXPECT_THAT(klipper.Execute("M114").lines[0], HasSubstr("Z:30.000"));
}

// Samples as [z_calibration] has them, where the command does not say.
// The endstop is elsewhere now: only what homes Z sees that.
TEST_F(KlipperZTest, HomingOtherAxesLeavesZ) {
  KlipperZ klipper(Config(), &heights_);
  EXPECT_TRUE(klipper.Execute("G28 X Y").lines.empty());
  EXPECT_TRUE(klipper.Execute("CALIBRATE_Z").error);  // Z was not homed.
  klipper.Execute("G28");
  const double before_mm = *klipper.CarriageAtNought_mm({0, 0});
  heights_.nozzle += 1;

  klipper.Execute("G28 X Y");
  EXPECT_EQ(*klipper.CarriageAtNought_mm({0, 0}), before_mm);
  klipper.Execute("G28 Z");
  EXPECT_NEAR(*klipper.CarriageAtNought_mm({0, 0}), before_mm + 1, 1e-12);
}

TEST_F(KlipperZTest, RefusesWhatIsOutOfRange) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("ATTACH_PROBE");

  for (const char* line : {"G0 Z99999",
                           "G0 X-5000",
                           "G0 Z-50",
                           "SET_GCODE_OFFSET Z=-100 MOVE=1",
                           "M104 S-9999",
                           "M140 S401",
                           "PROBE_ACCURACY SAMPLES=2.7",
                           "PROBE_ACCURACY SAMPLES=3e9"}) {
    EXPECT_TRUE(klipper.Execute(line).error) << line;
  }
  EXPECT_THAT(klipper.Execute("GET_POSITION").lines[3], HasSubstr("Z:0.000000"));
}

TEST_F(KlipperZTest, EndstopAccuracyTakesTheSectionsSamples) {
  ZCalibrationConfig config = Config();
  config.samples = 3;
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");
  const int before = klipper.touches();
  klipper.Execute("PROBE_Z_ACCURACY");

  EXPECT_EQ(klipper.touches() - before, 3);
}

TEST_F(KlipperZTest, AnOffsetBeyondMaxDeviationIsRefusedAndNotSet) {
  ZCalibrationConfig config = Config();
  config.max_deviation_mm = 0.2;  // It would be -0.275.
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");

  EXPECT_THAT(klipper.Execute("CALIBRATE_Z").lines.back(),
              HasSubstr("Offset is greater than allowed: 0.275 > 0.200"));
  EXPECT_THAT(klipper.Execute("GET_POSITION").lines[3], HasSubstr("Z:0.000000"));
}

TEST_F(KlipperZTest, AMacroThatCallsItselfIsRefused) {
  ZCalibrationConfig config = Config();
  config.start_gcode = "CALIBRATE_Z";
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");

  EXPECT_THAT(klipper.Execute("CALIBRATE_Z").lines.back(), HasSubstr("recursively"));
}

TEST_F(KlipperZTest, RefusesWhatTheExtensionRefuses) {
  ZCalibrationConfig negative = Config();
  negative.switch_offset_mm = -0.01;
  ZCalibrationConfig is_virtual = Config();
  is_virtual.is_virtual_endstop = true;
  ZCalibrationConfig unattached = Config();
  unattached.before_switch_gcode = "";
  const auto says = [&](const ZCalibrationConfig& config) {
    KlipperZ klipper(config, &heights_);
    klipper.Execute("G28");
    const Reply reply = klipper.Execute("CALIBRATE_Z");
    return reply.error ? reply.lines.back() : "";
  };

  EXPECT_THAT(says(negative), HasSubstr("must have minimum of 0.0"));
  EXPECT_THAT(says(is_virtual), HasSubstr("probe:z_virtual_endstop is not supported"));
  EXPECT_THAT(says(unattached), HasSubstr("Probe is not attached"));
  ZCalibrationConfig no_reference = Config();
  no_reference.bed_mesh = BedMeshConfig{};
  EXPECT_THAT(says(no_reference), HasSubstr("relative_reference_index"));
  KlipperZ not_homed(Config(), &heights_);
  EXPECT_THAT(not_homed.Execute("CALIBRATE_Z").lines.back(), HasSubstr("Must home"));
}

// A bed that leans: the mesh is 0 at its point of reference, follows the lean, and a
// nozzle moved over it keeps its height.
TEST_F(KlipperZTest, AMeshIsNoughtAtItsPointOfReference) {
  heights_.slope = {0.003, -0.002};
  ZCalibrationConfig config = Config();
  config.bed_mesh = BedMeshConfig{.min_mm = {20, 40},
                                  .max_mm = {220, 200},
                                  .count = {3, 5},
                                  .relative_reference_index = 4};
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");
  klipper.Execute("ATTACH_PROBE");

  EXPECT_THAT(klipper.Execute("BED_MESH_CALIBRATE").lines,
              ElementsAre("Mesh Bed Leveling Complete"));
  EXPECT_EQ(klipper.touches(), 1 + 15);

  // Index 4: the second along x, the second along y.
  const Eigen::Vector2d reference_mm(120, 80), there_mm(150, 170);
  EXPECT_NEAR(klipper.Mesh_mm(reference_mm), 0, 1e-12);
  EXPECT_NEAR(klipper.Mesh_mm(there_mm), 0.003 * 30 - 0.002 * 90, 1e-12);
  EXPECT_NEAR(klipper.Mesh_mm({500, 500}), klipper.Mesh_mm({220, 200}), 1e-12);

  klipper.Execute("G0 X120 Y80 Z5");
  klipper.Execute("G0 X150 Y170");
  const auto lines = klipper.Execute("GET_POSITION").lines;
  EXPECT_THAT(lines[0], HasSubstr("X:150.000000 Y:170.000000 Z:4.910000"));
  EXPECT_THAT(lines[2], HasSubstr("Z:5.000000"));

  klipper.Execute("BED_MESH_CLEAR");
  EXPECT_EQ(klipper.Mesh_mm(there_mm), 0);
}

TEST_F(KlipperZTest, CalibratesOnTheMeshsPointOfReference) {
  ZCalibrationConfig config = Config();
  config.bed_mesh = BedMeshConfig{.relative_reference_index = 5};
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");
  klipper.Execute("CALIBRATE_Z");
  EXPECT_EQ(heights_.last_at_mm, Eigen::Vector2d(215, 117.5));

  config.probe_bed_at_mm = Eigen::Vector2d(30, 40);
  KlipperZ elsewhere(config, &heights_);
  elsewhere.Execute("G28");
  elsewhere.Execute("CALIBRATE_Z");
  EXPECT_EQ(heights_.last_at_mm, Eigen::Vector2d(30, 40));
}

// Without one heights are over z_offset, wherever homing left the zero.
TEST_F(KlipperZTest, AMeshWithoutAReferenceIsOverTheProbesOffset) {
  ZCalibrationConfig config = Config();
  config.bed_mesh = BedMeshConfig{};
  config.probe_z_offset_mm = 6.5;
  KlipperZ klipper(config, &heights_);
  klipper.Execute("G28");  // Zero at 1.8 of the carriage.
  klipper.Execute("ATTACH_PROBE");
  klipper.Execute("BED_MESH_CALIBRATE");

  EXPECT_NEAR(klipper.Mesh_mm({100, 100}), 8.7 - 1.8 - 6.5, 1e-12);
}

TEST_F(KlipperZTest, DockingTakesAJourney) {
  ZCalibrationConfig config = Config();
  config.middle_mm = {100, 100};
  config.dock_mm = {100, 250};
  KlipperZ klipper(config, &heights_);
  EXPECT_THAT(klipper.Execute("ATTACH_PROBE").lines[0], HasSubstr("Must home"));
  klipper.Execute("G28");
  const double before_s = klipper.machine_time_s();

  klipper.Execute("ATTACH_PROBE");
  EXPECT_NEAR(klipper.machine_time_s() - before_s, 1 + 5, 1e-9);
  klipper.Execute("ATTACH_PROBE");  // It hangs already.
  EXPECT_NEAR(klipper.machine_time_s() - before_s, 1 + 5, 1e-9);
  klipper.Execute("DETACH_PROBE");
  EXPECT_NEAR(klipper.machine_time_s() - before_s, 1 + 10, 1e-9);
}

/// A switch that alternates.
class Shaky : public Heights {
 public:
  std::optional<double> Touch(ZTouch, const Eigen::Vector2d&) override {
    count_ += 1;
    return 1.5 + (count_ % 2 == 0 ? 0.02 : 0);
  }

 private:
  int count_ = 0;
};

TEST_F(KlipperZTest, SamplesBeyondTheirToleranceAreRefused) {
  Shaky shaky;
  ZCalibrationConfig config = Config();
  config.samples = 4;
  config.samples_tolerance_mm = 0.01;
  config.samples_tolerance_retries = 3;
  KlipperZ klipper(config, &shaky);
  klipper.Execute("G28");

  EXPECT_THAT(klipper.Execute("CALIBRATE_Z").lines.back(),
              HasSubstr("exceed samples_tolerance"));
  EXPECT_EQ(klipper.touches(), 1 + 4 * 4);
}

TEST_F(KlipperZTest, StatesTheStatisticsOfTheEndstop) {
  Shaky shaky;
  KlipperZ klipper(Config(), &shaky);
  klipper.Execute("G28");  // At 1.5.

  const Reply reply = klipper.Execute(
      "PROBE_Z_ACCURACY PROBE_SPEED=2 LIFT_SPEED=5 SAMPLES=4 "
      "SAMPLE_RETRACT_DIST=1");

  EXPECT_THAT(reply.lines,
              ElementsAre("probe accuracy results: maximum -0.280000, minimum "
                          "-0.300000, range 0.020000, average -0.290000, median "
                          "-0.290000, standard deviation 0.010000"));
}

}  // namespace
}  // namespace caltwin
