#pragma once

#include <atomic>

namespace caltwin {

/// Whether the person has asked to stop (Ctrl-C). Long work looks here between its
/// steps, keeps what it has and ends. Safe to call from a signal handler.
void RequestInterrupt();
bool InterruptRequested();
/// The same as a flag that others may watch.
const std::atomic<bool>& InterruptFlag();

}  // namespace caltwin
