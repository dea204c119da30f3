#include <array>
#include <optional>

#include <gtest/gtest.h>

#include "tests/firmware/every_cut.h"

namespace caltwin {
namespace {

constexpr int kCuts = 100'000;
constexpr std::size_t kAxes = 3;

AxisCalibration RandomRecord(Rng* rng) {
  return {.pulses_per_unit = 100 + 1000 * rng->Uniform(),
          .pulses_per_rev = 4096,
          .home_offset_pulses = static_cast<std::int32_t>(1e5 * rng->Normal()),
          .min_position_pulses = -1000,
          .max_position_pulses = 100'000,
          .backlash_pulses = 50 * rng->Normal(),
          .max_velocity_pulses_s = 1e5 * rng->Uniform() + 1,
          .max_acceleration_pulses_s2 = 1e6 * rng->Uniform() + 1};
}

// The 64th entry erases the other sector and moves there first: 8192 bytes erased, the
// newest 24 entries (records in force among them), the header, the entry.
TEST(RecordStore, ACutAfterAnyByteOfAMoveLeavesTheOldOrTheNewRecord) {
  const CutsTried tried = TryEveryCut(/*before=*/63);

  EXPECT_EQ(tried.lost, 0);
  EXPECT_EQ(tried.cuts, 8192 + (24 + 1 + 1) * 128 + 1);
  EXPECT_GT(tried.kept_old, 8192);
}

// One flash through 100 000 stores, each with the power cut somewhere or not at all,
// the sectors' moves among them. docs/storage.md has the figure.
TEST(RecordStore, LosesNoRecordInAHundredThousandCuts) {
  Rng rng(1, 0, "power");
  Flash flash;
  std::array<std::optional<AxisCalibration>, kAxes> in_force{};
  int lost = 0, torn = 0, went_through = 0;
  for (int i = 0; i < kCuts; ++i) {
    const auto axis = static_cast<std::size_t>(rng.Next() % kAxes);
    const AxisCalibration next = RandomRecord(&rng);
    RecordStore store(&flash);
    // Most stores are one entry of 128 bytes; some move 8192 erased and 27 entries.
    const bool is_long = rng.Next() % 8 == 0;
    flash.CutAfter(rng.Next() % (is_long ? 14'000 : 140), &rng);
    const bool is_done = store.Store(static_cast<std::uint8_t>(axis), next, i);
    flash.PowerUp();
    const RecordStore after(&flash);
    for (std::size_t k = 0; k < kAxes; ++k) {
      const auto found = after.Record(static_cast<std::uint8_t>(k));
      const bool is_new = k == axis && found == next;
      if (!is_new && found != in_force[k]) ++lost;
      if (k != axis) continue;
      if (is_done && !is_new) ++lost;
      torn += is_done ? 0 : 1;
      went_through += is_done ? 1 : 0;
    }
    for (std::size_t k = 0; k < kAxes; ++k) {
      in_force[k] = after.Record(static_cast<std::uint8_t>(k));
    }
  }

  EXPECT_EQ(lost, 0);
  EXPECT_GT(torn, kCuts / 3);
  EXPECT_GT(went_through, kCuts / 20);
}

}  // namespace
}  // namespace caltwin
