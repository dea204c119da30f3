#pragma once

namespace caltwin {

/// Whether the person has asked to stop (Ctrl-C). Long work looks here between its
/// steps, keeps what it has and ends. Safe to call from a signal handler.
void RequestInterrupt();
bool InterruptRequested();

}  // namespace caltwin
