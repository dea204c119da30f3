#include "sim/firmware/dialects/klipper_z.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Heights as told, no scatter.
class Heights : public ZStationPlant {
 public:
  std::optional<double> Touch(ZTouch touch) override {
    return touch == ZTouch::kNozzleOnSwitch ? nozzle
           : touch == ZTouch::kBodyOnSwitch ? body
                                            : bed;
  }
  void Heat(char, double) override {}
  double nozzle = 1.5, body = 8, bed = 8.7;
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

  EXPECT_NEAR(*klipper.CarriageAtNought_mm(), 1.8 - 0.275, 1e-9);
}

TEST_F(KlipperZTest, AdjustsAnOffsetAndMoves) {
  KlipperZ klipper(Config(), &heights_);
  klipper.Execute("G28");
  klipper.Execute("G0 Z5");
  klipper.Execute("SET_GCODE_OFFSET Z_ADJUST=0.05 MOVE=1");

  const auto lines = klipper.Execute("GET_POSITION").lines;
  EXPECT_THAT(lines[1], HasSubstr("Z:5.050000"));
  EXPECT_THAT(lines[2], HasSubstr("Z:5.000000"));
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
  KlipperZ not_homed(Config(), &heights_);
  EXPECT_THAT(not_homed.Execute("CALIBRATE_Z").lines.back(), HasSubstr("Must home"));
}

/// A switch that alternates.
class Shaky : public Heights {
 public:
  std::optional<double> Touch(ZTouch) override {
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
