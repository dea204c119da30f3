#pragma once

#include <cstdint>

namespace caltwin {
namespace klipper {

/// Ticks of the chip's clock since it was switched on; on the wire the lowest 32 bits.
using Clock = std::int64_t;

}  // namespace klipper
}  // namespace caltwin
