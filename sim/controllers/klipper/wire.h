#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace caltwin {
namespace klipper {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// @name A block on the wire between Klipper's host and a microcontroller
///
///   length, 0x10 | sequence, payload, CRC (high byte first), 0x7E
///
/// Length counts all of it.
inline constexpr std::size_t kShortestBlock = 5;
inline constexpr std::size_t kLongestBlock = 64;
inline constexpr std::size_t kMostPayload = kLongestBlock - kShortestBlock;
inline constexpr int kSequences = 16;

/// CRC-16/MCRF4XX (CCITT polynomial, reflected, begins with 0xFFFF): "123456789" has
/// 0x6F91.
std::uint16_t Crc16(ByteView bytes);

/// Appends a number of 32 bits in one to five bytes: seven bits each, the most
/// significant first, the top bit of all but the last set. -32..95 take one byte.
void AppendVlq(std::int32_t number, Bytes* bytes);

/// Takes a number from the front of `bytes`; nullopt where they end within it, or it is
/// longer than five bytes. An unsigned number is the same 32 bits.
std::optional<std::int32_t> TakeVlq(ByteView* bytes);

/// The block of that payload (at most kMostPayload bytes); of `sequence` the lowest
/// four bits are sent. An empty payload acknowledges what came before `sequence`.
Bytes BlockOf(int sequence, ByteView payload);

/// What a BlockReader found: a sound block, or damage that it skipped.
struct Received {
  bool is_sound = false;
  int sequence = 0;  ///< 0..15
  Bytes payload{};
};

/// Cuts a stream of bytes into blocks. Whatever is no block (a wrong length, CRC or
/// mark) is skipped up to the next 0x7E and told once as damage; marks between blocks
/// are nothing. Takes any bytes and keeps at most one block of them.
class BlockReader {
 public:
  void Feed(ByteView bytes);
  /// The next finding; nullopt until more bytes have come.
  std::optional<Received> Take();

 private:
  Received Skip();

  std::deque<std::uint8_t> waiting_{};
  bool is_lost_ = false;  ///< Within damage: up to the next mark nothing counts.
};

}  // namespace klipper
}  // namespace caltwin
