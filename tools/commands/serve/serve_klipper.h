#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string_view>

#include "sim/controllers/board.h"

namespace caltwin {

/// Serves a board as a Klipper microcontroller in real time, on a pseudo-terminal that
/// `path` becomes a link to (`[mcu] serial:` of the host). A host may come, go or be
/// killed, and another come after it: the machine stands where it was left.
///
/// Where the computer keeps the process waiting, or physics take longer than what they
/// are of, the chip's clock stands still meanwhile: to the host it is a slow one.
///
/// Blocks until `*stop`, which it notices within a fifth of a second. `ready` is called
/// once. Returns 0; throws InputError where `path` cannot be had. A reason to shut down
/// is told to `note`, once each.
int ServeKlipper(Board* board,
                 const std::filesystem::path& path,
                 const std::atomic<bool>* stop,
                 const std::function<void()>& ready,
                 const std::function<void(std::string_view why)>& note);

}  // namespace caltwin
