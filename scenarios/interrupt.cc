#include "scenarios/interrupt.h"

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

const std::atomic<bool>& InterruptFlag() {
  return requested;
}

}  // namespace caltwin
