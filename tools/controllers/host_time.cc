// Time for a host of the Klipper family, in lock-step with its microcontroller: a
// library that is loaded into the unmodified host (LD_PRELOAD) by `caltwin klipper`.
//
// The host's one clock (CLOCK_MONOTONIC_RAW) stands still while any of its threads
// works. When all of them wait, in poll() or for a condition of its C helper, and
// nothing is left to read, the microcontroller is asked for time
// (sim/controllers/klipper/host_time.h): it says how late it is, and whoever waited for
// that goes on. So a run takes as long as its computing, and the same run gives the
// same bytes, however busy the computer is.
//
// Needs nothing but the C library; knows nothing of the host's insides beyond the names
// of its C helper's file and of the calls below.

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include <dlfcn.h>
#include <unistd.h>

#include "tools/controllers/host_threads.h"
#include "tools/controllers/real_calls.h"

namespace {

using namespace caltwin::host_time;  // NOLINT(google-build-using-namespace)

bool IsOfHelper(void* caller) {
  Dl_info info;
  return dladdr(caller, &info) != 0 && info.dli_fname != nullptr &&
         strstr(info.dli_fname, "c_helper") != nullptr;
}

// The line is the one terminal that the C helper reads and writes.
bool IsLine(int descriptor, void* caller) {
  if (!is_on || !IsOfHelper(caller) || isatty(descriptor) == 0) return false;
  line = descriptor;
  return true;
}

thread_local int looks = 0;  // Of this thread, one after another, that found nothing.

// A loop that looks and looks, for less than the millisecond that poll() can wait,
// would never end: after so many looks each takes a microsecond.
int Look(pollfd* polled, nfds_t num) {
  constexpr int kLooks = 40;
  constexpr std::int64_t kLook_ns = 1000;
  const int ready = Real().poll(polled, num, 0);
  looks = ready == 0 ? looks + 1 : 0;
  if (looks > kLooks) now_ns += kLook_ns;
  return ready;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) {
  if (clock != CLOCK_MONOTONIC_RAW || !is_on) return Real().clock_gettime(clock, time);
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  const std::int64_t now = now_ns;
  time->tv_sec = now / kNsPerS;
  time->tv_nsec = now % kNsPerS;
  return 0;
}

// A sleep is a wait like another, by whole milliseconds: what of the time until then
// the computer has used up already is chance.
int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
  if (!is_on) return Real().clock_nanosleep(clock, flags, time, left);
  constexpr std::int64_t kMsPerS = 1000, kNsPerMs = 1'000'000;
  timespec now = {};
  if ((flags & TIMER_ABSTIME) != 0) Real().clock_gettime(clock, &now);
  const std::int64_t by_ns = time->tv_nsec - now.tv_nsec;
  const std::int64_t whole_ms = (time->tv_sec - now.tv_sec) * kMsPerS;
  const std::int64_t by_ms = whole_ms + (by_ns + kNsPerMs - 1) / kNsPerMs;
  if (by_ms > 0) poll(nullptr, 0, static_cast<int>(by_ms));
  return 0;
}

int poll(pollfd* polled, nfds_t num, int timeout_ms) {
  constexpr std::int64_t kNsPerMs = 1'000'000;
  if (!is_on || num >= kMostPolled) return Real().poll(polled, num, timeout_ms);
  if (timeout_ms == 0) return Look(polled, num);
  looks = 0;
  const int ready = Real().poll(polled, num, 0);
  if (ready != 0) return ready;

  Waiter* const waiter = Own();
  pollfd all[kMostPolled];
  std::copy_n(polled, num, all);
  all[num] = {.fd = waiter->wake, .events = POLLIN, .revents = 0};
  {
    const Guarded guarded;
    std::copy_n(polled, num, waiter->polled);
    waiter->num_polled = static_cast<int>(num);
    waiter->deadline_ns = timeout_ms < 0 ? kNever : now_ns + timeout_ms * kNsPerMs;
    BeginToWait(waiter);
  }
  const int code = Real().poll(all, num + 1, -1);
  const int error = errno;
  if (EndToWait(waiter)) {
    std::uint64_t once = 0;
    if (Real().read(waiter->wake, &once, sizeof once) < 0) _exit(kLostTwin);
  }
  if (code < 0) {
    errno = error;
    return code;
  }
  int num_ready = 0;
  for (nfds_t i = 0; i < num; ++i) {
    polled[i].revents = all[i].revents;
    num_ready += all[i].revents != 0 ? 1 : 0;
  }
  return num_ready;
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  if (!is_on || !IsOfHelper(__builtin_return_address(0))) {
    return Real().cond_wait(condition, mutex);
  }
  Waiter* const waiter = Own();
  {
    const Guarded guarded;
    waiter->condition = condition;
    waiter->deadline_ns = kNever;
    BeginToWait(waiter);
  }
  const int code = Real().cond_wait(condition, mutex);
  EndToWait(waiter);
  return code;
}

int pthread_cond_signal(pthread_cond_t* condition) {
  if (is_on) WakeThoseAt(condition);
  return Real().cond_signal(condition);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  const bool is_line = IsLine(descriptor, __builtin_return_address(0));
  const ssize_t num = Real().write(descriptor, bytes, size);
  if (is_line && num > 0) written_bytes += num;
  return num;
}

ssize_t read(int descriptor, void* bytes, size_t size) {
  const bool is_line = IsLine(descriptor, __builtin_return_address(0));
  const ssize_t num = Real().read(descriptor, bytes, size);
  if (is_line && num > 0) read_bytes += num;
  return num;
}

// It is not seen before it first waits: it is given time to get there.
int pthread_create(pthread_t* thread,
                   const pthread_attr_t* attributes,
                   void* (*function)(void*),
                   void* argument) {
  Newcomer* const place = is_on ? ComeIn(function, argument) : nullptr;
  if (place == nullptr) {
    return Real().thread_create(thread, attributes, function, argument);
  }
  const int code = Real().thread_create(thread, attributes, BeginThread, place);
  if (code != 0) place->begun_ns = 0;
  return code;
}

int sem_wait(sem_t* semaphore) {
  const Pausing pausing;
  return Real().sem_wait(semaphore);
}

int sem_clockwait(sem_t* semaphore, clockid_t clock, const timespec* until) {
  const Pausing pausing;
  return Real().sem_clockwait(semaphore, clock, until);
}

pid_t fork() {
  const pid_t child = Real().fork();
  if (is_on && child > 0) NoteChild(child);
  return child;
}

}  // extern "C"
