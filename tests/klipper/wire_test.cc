#include "sim/controllers/klipper/wire.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace klipper {
namespace {

using testing::ElementsAre;

Bytes VlqOf(std::int32_t number) {
  Bytes bytes;
  AppendVlq(number, &bytes);
  return bytes;
}

Bytes BytesOf(std::string_view text) {
  return {text.begin(), text.end()};
}

TEST(KlipperVlq, IsAsTheProtocolSays) {
  // The borders of docs/Protocol.md's table: -32..95, -4096..12287 and so on.
  EXPECT_THAT(VlqOf(0), ElementsAre(0x00));
  EXPECT_THAT(VlqOf(95), ElementsAre(0x5F));
  EXPECT_THAT(VlqOf(96), ElementsAre(0x80, 0x60));
  EXPECT_THAT(VlqOf(-1), ElementsAre(0x7F));
  EXPECT_THAT(VlqOf(-32), ElementsAre(0x60));
  EXPECT_THAT(VlqOf(-33), ElementsAre(0xFF, 0x5F));
  EXPECT_EQ(VlqOf(12287).size(), 2U);
  EXPECT_EQ(VlqOf(12288).size(), 3U);
  EXPECT_EQ(VlqOf(-4097).size(), 3U);
  EXPECT_EQ(VlqOf(1'572'864).size(), 4U);
  EXPECT_EQ(VlqOf(201'326'592).size(), 5U);
}

TEST(KlipperVlq, ComesBackAsItWent) {
  Rng rng(1, 0, "klipper.vlq");
  for (int i = 0; i < 2000; ++i) {
    const int bits = i % 32;
    constexpr double kMost = std::numeric_limits<std::int32_t>::max();
    const double drawn = std::clamp(rng.Normal() * (1U << bits), -kMost, kMost);
    const auto number = static_cast<std::int32_t>(drawn);
    const Bytes bytes = VlqOf(number);
    ByteView view = bytes;
    EXPECT_EQ(TakeVlq(&view), number);
    EXPECT_TRUE(view.empty());
  }
  for (const std::int32_t most : {std::numeric_limits<std::int32_t>::min(),
                                  std::numeric_limits<std::int32_t>::max()}) {
    const Bytes bytes = VlqOf(most);
    ByteView view = bytes;
    EXPECT_EQ(TakeVlq(&view), most);
  }
}

TEST(KlipperVlq, CutShortOrEndlessIsNone) {
  const Bytes cut = {0x80}, endless(9, 0xFF);
  ByteView a = cut, b = endless;
  EXPECT_EQ(TakeVlq(&a), std::nullopt);
  EXPECT_EQ(TakeVlq(&b), std::nullopt);
}

TEST(KlipperCrc, OfTheNineDigitsIsThePublishedCheck) {
  EXPECT_EQ(Crc16(BytesOf("123456789")), 0x6F91);  // CRC-16/MCRF4XX.
}

TEST(KlipperBlock, HasLengthSequencePayloadCrcAndMark) {
  // An acknowledgement of nothing, its CRC worked out by hand from the polynomial.
  const Bytes block = BlockOf(1, {});
  ASSERT_EQ(block.size(), 5U);
  EXPECT_EQ(block[0], 5);
  EXPECT_EQ(block[1], 0x11);
  EXPECT_EQ(block[2] * 256 + block[3], Crc16(Bytes{5, 0x11}));
  EXPECT_EQ(block[4], 0x7E);
  EXPECT_EQ(BlockOf(18, {})[1], 0x12);
}

TEST(KlipperBlockReader, TakesBlocksHoweverTheyAreCut) {
  Bytes stream = {0x7E, 0x7E};
  for (int i = 0; i < 3; ++i) {
    const Bytes payload(static_cast<std::size_t>(i), 0x7E);
    const Bytes block = BlockOf(i, payload);
    stream.insert(stream.end(), block.begin(), block.end());
  }
  BlockReader reader;
  std::vector<std::size_t> sizes;
  for (const std::uint8_t byte : stream) {
    reader.Feed(ByteView(&byte, 1));
    while (const auto received = reader.Take()) {
      EXPECT_TRUE(received->is_sound);
      EXPECT_EQ(received->sequence, static_cast<int>(sizes.size()));
      sizes.push_back(received->payload.size());
    }
  }
  EXPECT_THAT(sizes, ElementsAre(0, 1, 2));
}

TEST(KlipperBlockReader, TellsDamageOnceAndGoesOnBehindTheMark) {
  Bytes stream = BytesOf("ATZ\r\n noise ");
  stream.push_back(0x7E);
  const Bytes good = BlockOf(3, Bytes{9});
  Bytes flipped = good;
  flipped[2] ^= 1U;
  stream.insert(stream.end(), good.begin(), good.end());
  stream.insert(stream.end(), flipped.begin(), flipped.end());
  stream.insert(stream.end(), good.begin(), good.end());
  BlockReader reader;
  reader.Feed(stream);
  std::vector<bool> sound;
  while (const auto received = reader.Take()) sound.push_back(received->is_sound);
  EXPECT_THAT(sound, ElementsAre(false, true, false, true));
}

TEST(KlipperBlockReader, FindsTheBlockBehindAnyNoise) {
  Rng rng(2, 0, "klipper.noise");
  const Bytes good = BlockOf(5, Bytes{1, 2, 3});
  for (int round = 0; round < 200; ++round) {
    Bytes stream;
    for (int i = 0; i < round; ++i) {
      stream.push_back(static_cast<std::uint8_t>(rng.Uniform() * 256));
    }
    // What noise takes for the head of a block is at most a block long.
    stream.insert(stream.end(), kLongestBlock, 0x7E);
    stream.insert(stream.end(), good.begin(), good.end());
    BlockReader reader;
    reader.Feed(stream);
    std::optional<Received> last;
    while (auto received = reader.Take()) last = std::move(received);
    ASSERT_TRUE(last);
    EXPECT_TRUE(last->is_sound);
    EXPECT_THAT(last->payload, ElementsAre(1, 2, 3));
  }
}

}  // namespace
}  // namespace klipper
}  // namespace caltwin
