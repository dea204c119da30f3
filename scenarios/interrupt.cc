#include "scenarios/interrupt.h"

#include <atomic>

namespace caltwin {
namespace {

std::atomic<bool> requested = false;
static_assert(std::atomic<bool>::is_always_lock_free);

}  // namespace

void RequestInterrupt() {
  requested = true;
}

bool InterruptRequested() {
  return requested;
}

}  // namespace caltwin
