// The signs of a printer's station, each worked out by hand.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

constexpr double kExact = 1e-12;

Machine Station() {
  return {.name = "test", .kind = ZStationKind(), .own = ZStationDrawing{}};
}

// Chamber 10 K, bed 40 K and nozzle 200 K warmer than at the first reading of 20 degC.
const Climate& Hot() {
  static const Climate kClimate = [] {
    Climate climate;
    for (std::size_t i = 0; i < kNumSensors; ++i) climate.logs[i].Add(0, 20);
    const auto heat = [&](Sensor sensor, double temp_c) {
      climate.logs[static_cast<std::size_t>(sensor)].Add(10, temp_c);
    };
    heat(Sensor::kChamber, 30);
    heat(Sensor::kBed, 60);
    heat(Sensor::kNozzle, 220);
    return climate;
  }();
  return kClimate;
}

Row Reading(const std::string& feature) {
  Row row{.kind = feature == "bed.gap" ? RowKind::kPosition : RowKind::kTouch};
  row.cmd_mm = {120, 120, 2};
  row.n = {0, 0, 1};
  row.feature = feature;
  return row;
}

double Value_mm(const std::string& feature,
                const char* effect,
                const char* axis,
                std::vector<double> values) {
  const Machine machine = Station();
  const Row row = Reading(feature);
  At at = AtOf(row, machine, machine.settings);
  at.t_s = 3600;
  at.climate = &Hot();
  const std::vector<Injected> effects = {
      {.effect = *FindEffect(effect), .axis = axis, .values = std::move(values)}};
  return Predict_mm<double>(machine, at, effects);
}

// On nozzle, body, bed and of the gap.
void ExpectAdds(const char* effect,
                const char* axis,
                const std::vector<double>& values,
                const std::array<double, 4>& expected_mm) {
  constexpr std::array kFeatures = {
      "switch.nozzle", "switch.body", "bed.probe", "bed.gap"};
  for (std::size_t i = 0; i < kFeatures.size(); ++i) {
    EXPECT_NEAR(Value_mm(kFeatures[i], effect, axis, values), expected_mm[i], kExact)
        << effect << ' ' << kFeatures[i];
  }
}

TEST(SignsOfAStation, AHotNozzleIsLongerAndMeetsTheSwitchHigher) {
  ExpectAdds("nozzle_temperature", "", {0.3, 0}, {0.060, 0, 0, 0});
}

TEST(SignsOfAStation, OozeMeetsTheSwitchFirstAndLeavesTheNozzleTooHigh) {
  ExpectAdds("ooze", "", {120, 190}, {0.120, 0, 0, 0.120});
  ExpectAdds("ooze", "", {120, 221}, {0, 0, 0, 0});
}

TEST(SignsOfAStation, ASwitchOffsetTooSmallLeavesTheNozzleTooHigh) {
  ExpectAdds("switch_offset", "", {60}, {0, 0, 0.060, 0.060});
}

TEST(SignsOfAStation, AThickerPlateIsMetHigherAndTakenOutByCalibration) {
  ExpectAdds("station_change", "plate", {400, 100}, {0, 0, 0.400, 0});
  ExpectAdds("station_change", "nozzle", {400, 100}, {0.400, 0, 0, 0});
  ExpectAdds("station_change", "nozzle", {400, 4000}, {0, 0, 0, 0});
}

TEST(SignsOfAStation, AWarmBedRisesUnderTheProbeAlone) {
  ExpectAdds("frame_temperature", "bed", {0.5, 0}, {0, 0, 0.020, 0});
}

TEST(SignsOfAStation, AProbeThatTriggersLaterIsReadLowerAndLeavesTheNozzleTooLow) {
  ExpectAdds("probe_temperature", "", {2, 0}, {0, 0, -0.020, -0.020});
}

TEST(SignsOfAStation, AHeadThatIsLiftedComesDownFurtherWhateverItTouches) {
  ExpectAdds("frame_growth", "", {20, 1e-1}, {-0.020, -0.020, -0.020, 0});
}

TEST(SignsOfAStation, ARowOfNothingThatStandsThereIsRefused) {
  const Machine machine = Station();
  for (const Row& row : {Reading("bed.top"), Reading("")}) {
    EXPECT_THROW(AtOf(row, machine, machine.settings), InputError) << row.feature;
  }
  Row gauge = Reading("bed.gap");
  gauge.kind = RowKind::kTouch;
  EXPECT_THROW(AtOf(gauge, machine, machine.settings), InputError);
}

}  // namespace
}  // namespace caltwin
