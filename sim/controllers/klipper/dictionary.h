#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sim/controllers/board.h"
#include "sim/controllers/klipper/clock.h"
#include "sim/controllers/klipper/wire.h"

namespace caltwin {
namespace klipper {

/// @name What the dictionary tells the host of the chip
inline constexpr Clock kTicksPerSecond = 50'000'000;
inline constexpr int kAdcMax = 4095;
inline constexpr int kPwmMax = 255;
/// How many steps of a queue and changes of outputs it can hold.
inline constexpr int kMoveCount = 1024;

/// The words with which a microcontroller stops, by number.
std::span<const std::string_view> ShutdownWords();

/// JSON of everything that the host has to know before it can speak to this board:
/// formats, pins by number, words of a shutdown, constants.
std::string DictionaryJson(const Board& board);

/// The same as `identify` hands it out, compressed by zlib.
Bytes CompressedDictionary(const Board& board);

}  // namespace klipper
}  // namespace caltwin
