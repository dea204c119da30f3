#include "sim/firmware/record_store.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "tests/firmware/every_cut.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const AxisCalibration kOld = OldRecord();

AxisCalibration Newer() {
  return NewerRecord();
}

TEST(AxisCalibration, AllNineFieldsComeBackFromTheirBytes) {
  EXPECT_EQ(Decode(Encode(kOld)), kOld);
  EXPECT_EQ(Decode(Encode(Newer())), Newer());
}

TEST(AxisCalibration, EveryFieldIsCheckedForItsRange) {
  AxisCalibration bad{.pulses_per_unit = 0,
                      .pulses_per_rev = 0,
                      .min_position_pulses = 5,
                      .max_position_pulses = 5,
                      .backlash_pulses = std::numeric_limits<double>::quiet_NaN(),
                      .index_enabled = true,
                      .max_velocity_pulses_s = -1,
                      .max_acceleration_pulses_s2 = 1e13};

  EXPECT_THAT(
      RangeFaults(bad),
      ElementsAre("pulses_per_unit = 0, allowed 0.001 to 1e+07",
                  "backlash_pulses = nan, allowed -1e+06 to 1e+06",
                  "max_velocity_pulses_s = -1, allowed 0.001 to 1e+09",
                  "max_acceleration_pulses_s2 = 1e+13, allowed 0.001 to 1e+12",
                  "pulses_per_rev = 0, allowed only where no index is enabled",
                  "min_position_pulses = 5, allowed below max_position_pulses = 5"));
  EXPECT_THAT(RangeFaults(kOld), IsEmpty());
  EXPECT_FALSE(Decode(Encode(bad)));
}

TEST(Crc32, IsThatOfIeee8023) {
  const std::string digits = "123456789";
  const std::vector<std::uint8_t> bytes(digits.begin(), digits.end());

  EXPECT_EQ(Crc32(bytes), 0xCBF43926U);
}

// What a whole number of pulses per mm costs: f / s of the travel, f the fraction that
// is dropped.
TEST(PublishedCalibration, WholePulsesPerMmCostHundredsOfMicrometres) {
  constexpr double kTravel_mm = 300;
  const auto cost_um = [&](double pulses_per_mm) {
    const auto kept = AsPublished({.pulses_per_unit = pulses_per_mm}).pulses_per_mm;
    // The controller that believes `kept` sends so many pulses for the travel.
    const double moved_mm = kTravel_mm * kept / pulses_per_mm;
    return UmFromMm(kTravel_mm - moved_mm);
  };

  EXPECT_NEAR(cost_um(409.6), 300e3 * 0.6 / 409.6, 1e-6);        // 439.5 um
  EXPECT_NEAR(cost_um(400.123), 300e3 * 0.123 / 400.123, 1e-6);  // 92.2 um
  EXPECT_EQ(Decode(Encode({.pulses_per_unit = 409.6}))->pulses_per_unit, 409.6);
}

TEST(PublishedCalibration, ABacklashOf16BitsLosesFractionsWrapsAndHasNoSign) {
  constexpr double kPulsesPerMm = 409.6;
  const auto kept_mm = [&](double backlash_mm) {
    const AxisCalibration record{.backlash_pulses = backlash_mm * kPulsesPerMm};
    return AsPublished(record).backlash_pulses / kPulsesPerMm;
  };

  // 20.48 pulses become 20: 1.2 um of 50.
  EXPECT_NEAR(UmFromMm(0.05 - kept_mm(0.05)), UmFromMm(0.48 / kPulsesPerMm), 1e-6);
  // Compensated by 10 um too much: -4 pulses become 65532, 160 mm.
  EXPECT_NEAR(kept_mm(-0.01), 65'532 / kPulsesPerMm, 1e-9);
  // At 20 nm a pulse, 65535 are 1.3 mm; a worn rack of 2 mm is kept as 0.689.
  const AxisCalibration fine{.backlash_pulses = 2 * 50'000.0};
  EXPECT_EQ(AsPublished(fine).backlash_pulses, 100'000 - 65'536);
}

TEST(RecordStore, KeepsEachAxisAndItsHistoryWithTimes) {
  Flash flash;
  RecordStore store(&flash);
  EXPECT_FALSE(store.Record(0));

  ASSERT_TRUE(store.Store(0, kOld, 1000));
  ASSERT_TRUE(store.Store(1, Newer(), 2000));
  ASSERT_TRUE(store.Note(0, "index missing", 3000));
  const RecordStore later(&flash);

  EXPECT_EQ(later.Record(0), kOld);
  EXPECT_EQ(later.Record(1), Newer());
  ASSERT_EQ(later.history().size(), 3U);
  EXPECT_EQ(later.history()[1].unix_s, 2000);
  EXPECT_EQ(later.history()[2].note, "index missing");
}

TEST(RecordStore, AFactoryResetForgetsTheRecordsAndKeepsTheHistory) {
  Flash flash;
  RecordStore store(&flash);
  ASSERT_TRUE(store.Store(0, kOld, 1000));
  ASSERT_TRUE(store.Store(1, kOld, 1001));

  ASSERT_TRUE(store.FactoryReset(0, 2000));
  EXPECT_FALSE(RecordStore(&flash).Record(0));
  EXPECT_TRUE(RecordStore(&flash).Record(1));
  ASSERT_TRUE(store.FactoryReset(kAllAxes, 3000));
  EXPECT_FALSE(RecordStore(&flash).Record(1));
  EXPECT_EQ(RecordStore(&flash).history().size(), 4U);
}

// 200 entries through two sectors of 63: what is in force moves along.
TEST(RecordStore, OutlivesMoreEntriesThanASectorHolds) {
  Flash flash;
  RecordStore store(&flash);
  ASSERT_TRUE(store.Store(3, kOld, 1));
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(store.Store(0, Newer(), i));

  const RecordStore later(&flash);
  EXPECT_EQ(later.Record(3), kOld);
  EXPECT_EQ(later.Record(0), Newer());
  EXPECT_EQ(later.history().back().sequence, 201U);
  EXPECT_EQ(later.history().back().unix_s, 199);
  EXPECT_GE(later.history().size(), 24U);
}

TEST(RecordStore, ABitThatFlipsIsNoticed) {
  Flash flash;
  RecordStore store(&flash);
  ASSERT_TRUE(store.Store(0, kOld, 1));
  ASSERT_TRUE(store.Store(0, Newer(), 2));
  // The second entry stands in the third slot; a zero byte of it loses nothing more,
  // so clear one of its doubles.
  const std::array<std::uint8_t, 4> none{};
  ASSERT_TRUE(flash.Program(2 * 128 + 20 + 4, none));

  EXPECT_EQ(RecordStore(&flash).Record(0), kOld);
}

// Every byte of an append is a place where the power may go; those of a move to the
// other sector are in record_store_slow_test.cc.
TEST(RecordStore, ACutAfterAnyByteLeavesTheOldOrTheNewRecord) {
  const CutsTried tried = TryEveryCut(/*before=*/5);

  EXPECT_EQ(tried.lost, 0);
  EXPECT_EQ(tried.cuts, 129);
  EXPECT_GT(tried.kept_old, 100);
}

}  // namespace
}  // namespace caltwin
