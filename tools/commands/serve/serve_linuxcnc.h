#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/controllers/board.h"

namespace caltwin {

/// Serves a board to a LinuxCNC whose component has `loadrt caltwin page=NAME`: on the
/// page /dev/shm/NAME, servo cycle by servo cycle, in LinuxCNC's time. A LinuxCNC may
/// come, go or be killed, and another come after it: the machine stands where it was
/// left, and LinuxCNC has to home.
///
/// Blocks until `*stop`, which it notices within a fifth of a second. `ready` is called
/// once. Throws InputError where the page cannot be had.
void ServeLinuxCnc(Board* board,
                   const std::string& name,
                   const std::atomic<bool>* stop,
                   const std::function<void()>& ready);

}  // namespace caltwin
