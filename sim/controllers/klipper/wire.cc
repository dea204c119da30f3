#include "sim/controllers/klipper/wire.h"

#include <algorithm>

#include <boost/crc.hpp>

#include "sim/base/require.h"

namespace caltwin {
namespace klipper {
namespace {

constexpr std::uint8_t kMark = 0x7E;
constexpr std::uint8_t kSequenceMark = 0x10;
constexpr std::size_t kHead = 2;  // Length and sequence.
constexpr std::size_t kTail = 3;  // CRC and mark.
constexpr int kLongestVlq = 5;

}  // namespace

std::uint16_t Crc16(ByteView bytes) {
  // CRC-16/MCRF4XX: CCITT's polynomial, reflected, from all ones.
  boost::crc_optimal<16, 0x1021, 0xFFFF, 0, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

void AppendVlq(std::int32_t number, Bytes* bytes) {
  // So many bytes of seven bits hold -2^(7n-2) .. 3 2^(7n-2) - 1: of the topmost byte
  // 0x60..0x7F stand for what is negative.
  int num = 1;
  for (std::int64_t least = 32; num < kLongestVlq; ++num, least *= 128) {
    if (number >= -least && number < 3 * least) break;
  }
  const auto bits = static_cast<std::uint32_t>(number);
  for (int i = num - 1; i >= 0; --i) {
    const unsigned more = i > 0 ? 0x80U : 0U;
    bytes->push_back(static_cast<std::uint8_t>(((bits >> (7U * i)) & 0x7FU) | more));
  }
}

std::optional<std::int32_t> TakeVlq(ByteView* bytes) {
  std::uint32_t bits = 0;
  for (int i = 0; i < kLongestVlq; ++i) {
    if (bytes->empty()) return std::nullopt;
    const std::uint8_t byte = bytes->front();
    *bytes = bytes->subspan(1);
    const bool is_negative = i == 0 && (byte & 0x60U) == 0x60U;
    if (is_negative) bits = ~0U;
    bits = (bits << 7U) | (byte & 0x7FU);
    if ((byte & 0x80U) == 0) return static_cast<std::int32_t>(bits);
  }
  return std::nullopt;
}

Bytes BlockOf(int sequence, ByteView payload) {
  Require(payload.size() <= kMostPayload, "a payload fits into its block");
  Bytes block;
  block.reserve(payload.size() + kShortestBlock);
  block.push_back(static_cast<std::uint8_t>(payload.size() + kShortestBlock));
  block.push_back(static_cast<std::uint8_t>(
      kSequenceMark | (static_cast<unsigned>(sequence) % kSequences)));
  block.insert(block.end(), payload.begin(), payload.end());
  const unsigned crc = Crc16(block);
  block.push_back(static_cast<std::uint8_t>(crc >> 8U));
  block.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  block.push_back(kMark);
  return block;
}

void BlockReader::Feed(ByteView bytes) {
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

Received BlockReader::Skip() {
  is_lost_ = true;
  return {};
}

std::optional<Received> BlockReader::Take() {
  if (is_lost_) {
    const auto mark = std::find(waiting_.begin(), waiting_.end(), kMark);
    is_lost_ = mark == waiting_.end();
    waiting_.erase(waiting_.begin(), mark);
  }
  while (!waiting_.empty() && waiting_.front() == kMark) waiting_.pop_front();
  if (waiting_.size() < kHead) return std::nullopt;
  const std::size_t length = waiting_[0];
  const std::uint8_t sequence = waiting_[1];
  const bool is_head = length >= kShortestBlock && length <= kLongestBlock &&
                       (sequence & 0xF0U) == kSequenceMark;
  if (!is_head) return Skip();
  if (waiting_.size() < length) return std::nullopt;
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(length);
  const Bytes block(waiting_.begin(), end);
  const ByteView checked(block.data(), length - kTail);
  const unsigned crc = block[length - 3] * 256U + block[length - 2];
  if (block.back() != kMark || Crc16(checked) != crc) return Skip();
  waiting_.erase(waiting_.begin(), end);
  const ByteView payload = checked.subspan(kHead);
  return Received{.is_sound = true,
                  .sequence = sequence % kSequences,
                  .payload = Bytes(payload.begin(), payload.end())};
}

}  // namespace klipper
}  // namespace caltwin
