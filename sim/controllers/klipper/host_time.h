#pragma once

#include <cstdint>

namespace caltwin {
namespace klipper {

/// What a host and its microcontroller say to each other of time, in lock-step. The
/// host's side is a library that is loaded into the host's process (tools/controllers/
/// host_time.cc) and knows nothing of the rest: plain numbers, as they stand in memory,
/// on a socket whose descriptor that environment variable names.
///
/// The host says HostWaits when all of its threads wait and nothing is left for them to
/// read; the answer is a Grant. Parked, it waits for another Grant, whose numbers do
/// not count, and then looks at its threads again.
inline constexpr const char* kHostTimeVariable = "CALTWIN_HOST_TIME";

struct HostWaits {
  std::int64_t deadline_ns = 0;    ///< When the first of them waits no longer.
  std::int64_t written_bytes = 0;  ///< So many it has written to the line, in all.
  std::int64_t now_ns = 0;         ///< What its clock shows.
};

struct Grant {
  std::int64_t is_parked = 0;   ///< 1: no time for now.
  std::int64_t now_ns = 0;      ///< What its clock is to show.
  std::int64_t sent_bytes = 0;  ///< So many have been sent to it on the line, in all.
};

/// What the host's clock shows at its start, and the microcontroller's has shown for so
/// long: a host takes a chip that has just been switched on for one that was reset.
inline constexpr std::int64_t kHostStart_ns = 1000LL * 1'000'000'000;
inline constexpr std::int64_t kChipStart_ns = 990LL * 1'000'000'000;

}  // namespace klipper
}  // namespace caltwin
