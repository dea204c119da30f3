#include "calibration/diagnosis/nothing_found.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Diagnosis Drifted(double log_odds) {
  Diagnosis diagnosis{.wander_um_per_sqrt_h = 5};
  diagnosis.weighed = {
      {.cause = "unknown", .axis = "z", .covariates = {"temp"}, .log_odds = log_odds}};
  return diagnosis;
}

TEST(NameTheLead, SaysWhatGoesAlongWithADrift) {
  Diagnosis diagnosis = Drifted(300);
  NameTheLead(&diagnosis);
  EXPECT_THAT(
      diagnosis.remarks,
      ElementsAre(HasSubstr("something that depends on temperature (log odds")));
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone);
}

TEST(NameTheLead, WhatNoiseMayMakeIsNone) {
  Diagnosis weak = Drifted(3);
  NameTheLead(&weak);
  EXPECT_THAT(weak.remarks, IsEmpty());

  Diagnosis still = Drifted(300);
  still.wander_um_per_sqrt_h = 0;
  NameTheLead(&still);
  EXPECT_THAT(still.remarks, IsEmpty());
}

TEST(DoubtNone, FarMoreThanNoiseIsNotNothing) {
  Diagnosis diagnosis = Drifted(300);
  DoubtNone({.rms_mm = 0.010, .floor_mm = 0.001, .chance = 1e-9}, &diagnosis);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknownStructure);
  EXPECT_THAT(diagnosis.remarks, ElementsAre(HasSubstr("depends on temperature")));

  Diagnosis as_noise = Drifted(300);
  DoubtNone({.rms_mm = 0.0015, .floor_mm = 0.001, .chance = 1e-9}, &as_noise);
  EXPECT_EQ(as_noise.verdict, DiagnosisVerdict::kNone);
}

TEST(DoubtNone, TheFastestWanderThatIsTriedMayBeNone) {
  Diagnosis diagnosis = Drifted(300);
  DoubtNone({.rms_mm = 0.0015, .floor_mm = 0.001, .chance = 1, .wanders_most = true},
            &diagnosis);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknownStructure);
  EXPECT_THAT(diagnosis.remarks, ElementsAre(HasSubstr("5 um per root hour or more")));
}

}  // namespace
}  // namespace caltwin
