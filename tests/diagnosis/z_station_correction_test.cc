// What Klipper is told of a wrong switch_offset.
#include "calibration/diagnosis/kinds/z_station_correction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/correction.h"
#include "sim/base/input_error.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// One gap, measured with these values of switch_offset in force.
Observed OneGap(const std::vector<double>& in_force_mm) {
  Row row{.kind = RowKind::kPosition, .setup = "bed.gap"};
  row.cmd_mm = {0, 0, 0};
  row.n = {0, 0, 1};
  row.feature = "bed.gap";
  DataHeader header;
  for (const double value : in_force_mm) {
    header.settings["s" + std::to_string(header.settings.size())].switch_offset_mm =
        value;
  }
  return {{.rows = {row}},
          header,
          ReadMachine(CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml"),
          {}};
}

Diagnosis Off(double off_um) {
  Diagnosis diagnosis;
  diagnosis.findings.push_back(
      {.cause = "switch_offset",
       .parameters = {{.name = "off_um", .value = off_um, .sd = 3}}});
  return diagnosis;
}

std::string TextFor(double off_um, const std::vector<double>& in_force_mm) {
  return CorrectionFor(
             ControllerKind::kKlipper, Off(off_um), OneGap(in_force_mm), "fix")
      .at(0)
      .text;
}

// A nozzle that hangs too high wants a greater one: offset = probe - (... + it).
TEST(ZStationCorrection, AddsWhatIsFoundToTheOneInForce) {
  EXPECT_THAT(TextFor(25, {0.475}), HasSubstr("\nswitch_offset: 0.5000\n"));
  EXPECT_THAT(TextFor(-40, {0.675}), HasSubstr("\nswitch_offset: 0.6350\n"));
}

TEST(ZStationCorrection, TakesTheDrawnOneWhereTheRowsDoNotSay) {
  EXPECT_THAT(TextFor(25, {}), HasSubstr("\nswitch_offset: 0.5250\n"));
}

TEST(ZStationCorrection, OfSeveralInForceSaysOnlyTheChange) {
  const std::string text = TextFor(25, {0.475, 0.5});

  EXPECT_THAT(text, HasSubstr("change it by +0.0250 +- 0.0030 mm"));
  EXPECT_THAT(text, Not(HasSubstr("\nswitch_offset:")));
}

TEST(ZStationCorrection, WhatMayBeOozeIsNotSet) {
  Diagnosis diagnosis = Off(25);
  diagnosis.findings[0].candidates = {{.cause = "switch_offset", .probability = 0.99},
                                      {.cause = "ooze", .structural = true}};

  const std::string text =
      ZStationCorrectionText(ControllerKind::kKlipper, diagnosis, OneGap({}));

  EXPECT_THAT(text, HasSubstr("it may be ooze as well"));
  EXPECT_THAT(text, Not(HasSubstr("\nswitch_offset:")));
}

TEST(ZStationCorrection, WhatNoSettingCarriesIsSaid) {
  Diagnosis diagnosis;
  diagnosis.findings.push_back({.cause = "ooze"});

  EXPECT_THAT(
      ZStationCorrectionText(ControllerKind::kKlipper, diagnosis, OneGap({})),
      HasSubstr("# ooze: no line for Klipper is written for this. Wipe the nozzle"));
}

TEST(ZStationCorrection, OtherControllersAreRefused) {
  EXPECT_THROW(RequireZCalibration(ControllerKind::kMarlin), InputError);
}

}  // namespace
}  // namespace caltwin
