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

#include "sim/controllers/klipper/host_time.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

namespace {

using caltwin::klipper::Grant;
using caltwin::klipper::HostWaits;

constexpr std::int64_t kNever = INT64_MAX;
constexpr int kLostTwin = 9;     // The host's exit code where the twin is gone.
constexpr int kMostPolled = 64;  // Descriptors of one call.
constexpr int kMostChildren = 64;

// A thread of the host that has waited at least once. Those that never do in a way that
// is seen here, as the one that writes the log, are nobody's concern.
struct Waiter {
  bool is_waiting = false;
  bool is_woken = false;  // By time or by a condition: counts as working already.
  std::int64_t deadline_ns = kNever;
  pollfd polled[kMostPolled] = {};
  int num_polled = 0;
  int wake = -1;                        // Readable: its deadline has come.
  pthread_cond_t* condition = nullptr;  // What it waits for.
  Waiter* next = nullptr;
};

// The C library's own.
struct RealCalls {
  int (*poll)(pollfd*, nfds_t, int);
  int (*clock_gettime)(clockid_t, timespec*);
  int (*clock_nanosleep)(clockid_t, int, const timespec*, timespec*);
  int (*cond_wait)(pthread_cond_t*, pthread_mutex_t*);
  int (*cond_signal)(pthread_cond_t*);
  ssize_t (*write)(int, const void*, size_t);
  ssize_t (*read)(int, void*, size_t);
  pid_t (*fork)();
  int (*thread_create)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  int (*sem_wait)(sem_t*);
  int (*sem_clockwait)(sem_t*, clockid_t, const timespec*);
};

template <typename Function>
void Find(Function* function, const char* name) {
  *reinterpret_cast<void**>(function) = dlsym(RTLD_NEXT, name);
}

// Not at load time: other libraries' beginnings may already call.
const RealCalls& Real() {
  static RealCalls all;
  static const bool is_found = [] {
    Find(&all.poll, "poll");
    Find(&all.clock_gettime, "clock_gettime");
    Find(&all.clock_nanosleep, "clock_nanosleep");
    Find(&all.cond_wait, "pthread_cond_wait");
    Find(&all.cond_signal, "pthread_cond_signal");
    Find(&all.write, "write");
    Find(&all.read, "read");
    Find(&all.fork, "fork");
    Find(&all.thread_create, "pthread_create");
    Find(&all.sem_wait, "sem_wait");
    Find(&all.sem_clockwait, "sem_clockwait");
    return true;
  }();
  static_cast<void>(is_found);
  return all;
}

std::atomic<bool> is_on{false};
std::atomic<std::int64_t> now_ns{caltwin::klipper::kHostStart_ns};
std::atomic<std::int64_t> written_bytes{0}, read_bytes{0};
int twin = -1;               // The socket.
std::atomic<int> line = -1;  // The terminal, once the C helper has used it.

// All below are guarded by `guard`.
pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;
pthread_cond_t all_wait = PTHREAD_COND_INITIALIZER;
Waiter* waiters = nullptr;
int num_working = 0;
std::int64_t sent_bytes = 0;  // To the host, as the twin said.
pid_t children[kMostChildren] = {};

// A thread that has begun and has not yet waited where it is seen: it may be about to.
struct Newcomer {
  std::int64_t begun_ns = 0;  // By the computer's clock; 0: nobody.
  bool has_paused = false;    // For another thread of the host: it may stay unseen.
  void* (*function)(void*) = nullptr;
  void* argument = nullptr;
};
constexpr int kMostNewcomers = 64;
Newcomer newcomers[kMostNewcomers];
thread_local Newcomer* as_newcomer = nullptr;

pthread_key_t at_thread_end;
thread_local Waiter* own = nullptr;

// [ns]
std::int64_t ComputerTime() {
  timespec now = {};
  Real().clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

class Guarded {
 public:
  Guarded() { pthread_mutex_lock(&guard); }
  ~Guarded() { pthread_mutex_unlock(&guard); }
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;
};

// The thread is a newcomer no more.
void Arrive() {
  if (as_newcomer == nullptr) return;
  const Guarded guarded;
  as_newcomer->begun_ns = 0;
  as_newcomer = nullptr;
}

void* BeginThread(void* as) {
  as_newcomer = static_cast<Newcomer*>(as);
  void* const result = as_newcomer->function(as_newcomer->argument);
  Arrive();
  return result;
}

// So long a newcomer is waited for, by the computer's clock.
bool IsAnyNewcomer() {
  constexpr std::int64_t kUsual_ns = 50'000'000, kLongest_ns = 2'000'000'000;
  const std::int64_t now = ComputerTime();
  for (const Newcomer& one : newcomers) {
    const std::int64_t longest_ns = one.has_paused ? kUsual_ns : kLongest_ns;
    if (one.begun_ns != 0 && now < one.begun_ns + longest_ns) return true;
  }
  return false;
}

void NoteThreadEnd(void* waiter) {
  const Guarded guarded;
  auto* const ended = static_cast<Waiter*>(waiter);
  for (Waiter** one = &waiters; *one != nullptr; one = &(*one)->next) {
    if (*one != ended) continue;
    *one = ended->next;
    break;
  }
  close(ended->wake);
  delete ended;
  if (--num_working == 0) Real().cond_signal(&all_wait);
}

Waiter* Own() {
  if (own != nullptr) return own;
  Arrive();
  own = new Waiter;
  own->wake = eventfd(0, EFD_CLOEXEC);
  pthread_setspecific(at_thread_end, own);
  const Guarded guarded;
  own->next = waiters;
  waiters = own;
  ++num_working;
  return own;
}

void BeginToWait(Waiter* waiter) {
  waiter->is_waiting = true;
  waiter->is_woken = false;
  if (--num_working == 0) Real().cond_signal(&all_wait);
}

// Whether it was woken by time.
bool EndToWait(Waiter* waiter) {
  const Guarded guarded;
  if (!waiter->is_woken) ++num_working;
  waiter->is_waiting = false;
  waiter->num_polled = 0;
  waiter->condition = nullptr;
  return waiter->is_woken;
}

// ---- The thread that asks for time

// Whether anything is there to read for a thread that is about to wake. What was sent
// on the line may be on its way a moment longer; where nobody listens, it is lost.
bool IsAnyReady() {
  bool has_listener = false;
  for (Waiter* one = waiters; one != nullptr; one = one->next) {
    if (!one->is_waiting || one->num_polled == 0) continue;
    const auto num = static_cast<nfds_t>(one->num_polled);
    if (Real().poll(one->polled, num, 0) > 0) return true;
    for (nfds_t i = 0; i < num; ++i) {
      has_listener = has_listener || one->polled[i].fd == line;
    }
  }
  return has_listener && read_bytes != sent_bytes;
}

// Where nobody waits for a time, some program is waited for that the host has started.
// A process that the host has forked computes for it. Its result is there when it has
// ended, and the host looks for it by the clock.
bool IsAnyChildAtWork() {
  bool works = false;
  for (pid_t& child : children) {
    if (child == 0) continue;
    siginfo_t info = {};
    const int code =
        waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
    const bool has_ended = code != 0 || info.si_pid == child;
    if (has_ended) child = 0;
    works = works || !has_ended;
  }
  return works;
}

std::int64_t FirstDeadline() {
  std::int64_t first = kNever;
  for (const Waiter* one = waiters; one != nullptr; one = one->next) {
    const bool counts = one->is_waiting && one->deadline_ns < first;
    if (counts) first = one->deadline_ns;
  }
  return first;
}

void WakeThoseDue() {
  for (Waiter* one = waiters; one != nullptr; one = one->next) {
    const bool is_due = one->is_waiting && !one->is_woken &&
                        one->condition == nullptr && one->deadline_ns <= now_ns;
    if (!is_due) continue;
    one->is_woken = true;
    ++num_working;
    const std::uint64_t once = 1;
    if (Real().write(one->wake, &once, sizeof once) < 0) _exit(kLostTwin);
  }
}

// The twin is gone: so is the machine.
void Exchange(void* bytes, std::size_t size, bool sends) {
  auto* at = static_cast<char*>(bytes);
  while (size > 0) {
    // Guarded on purpose: no thread may go on before it is known what time it is.
    const ssize_t num = sends ? send(twin, at, size, MSG_NOSIGNAL)
                              : recv(twin, at, size, 0);  // NOLINT(clang-analyzer-*)
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) _exit(kLostTwin);
    at += num;
    size -= static_cast<std::size_t>(num);
  }
}

void Pause(long pause_ns) {
  const timespec pause{.tv_sec = 0, .tv_nsec = pause_ns};
  Real().clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
}

// Asks once, all threads waiting; returns whether the twin has no time for now.
bool AskForTime() {
  HostWaits waits{
      .deadline_ns = FirstDeadline(), .written_bytes = written_bytes, .now_ns = now_ns};
  Exchange(&waits, sizeof waits, true);
  Grant grant;
  Exchange(&grant, sizeof grant, false);
  if (grant.is_parked != 0) return true;
  now_ns = grant.now_ns;
  sent_bytes = grant.sent_bytes;
  WakeThoseDue();
  return false;
}

// A host that computes, or waits for what will never come, asks nobody: it notices too
// that the twin was killed.
void EndWithoutTwin() {
  pollfd socket{.fd = twin, .events = POLLRDHUP, .revents = 0};
  if (Real().poll(&socket, 1, 0) > 0 && (socket.revents & (POLLRDHUP | POLLHUP)) != 0) {
    _exit(kLostTwin);
  }
}

// Until all wait, guarded.
void AwaitAll() {
  constexpr long kGlance_s = 1;
  while (num_working != 0 || waiters == nullptr) {
    timespec until = {};
    Real().clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += kGlance_s;
    pthread_cond_timedwait(&all_wait, &guard, &until);
    EndWithoutTwin();
  }
}

void* AskAlways(void* /*unused*/) {
  constexpr long kGlance_ns = 5'000, kChild_ns = 300'000;
  for (;;) {
    bool is_parked = false;
    long pause_ns = 0;
    {
      const Guarded guarded;
      AwaitAll();
      if (IsAnyReady() || IsAnyNewcomer()) {
        pause_ns = kGlance_ns;
      } else if (FirstDeadline() == kNever || IsAnyChildAtWork()) {
        pause_ns = kChild_ns;
      } else {
        is_parked = AskForTime();
      }
    }
    if (pause_ns > 0) {
      Pause(pause_ns);
      EndWithoutTwin();
    }
    if (!is_parked) continue;
    Grant go_on;
    Exchange(&go_on, sizeof go_on, false);
  }
}

__attribute__((constructor)) void Begin() {
  const char* const number = getenv(caltwin::klipper::kHostTimeVariable);
  if (number == nullptr) return;
  twin = atoi(number);
  // Not for the programs that the host runs.
  unsetenv(caltwin::klipper::kHostTimeVariable);
  unsetenv("LD_PRELOAD");
  pthread_key_create(&at_thread_end, NoteThreadEnd);
  pthread_atfork(nullptr, nullptr, [] { is_on = false; });
  Own();  // The first thread works from the beginning.
  is_on = true;
  pthread_t thread;
  Real().thread_create(&thread, nullptr, AskAlways, nullptr);
  pthread_detach(thread);
}

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

void Sleep(std::int64_t by_ns) {
  Waiter* const waiter = Own();
  {
    const Guarded guarded;
    waiter->deadline_ns = now_ns + by_ns;
    BeginToWait(waiter);
  }
  pollfd wake{.fd = waiter->wake, .events = POLLIN, .revents = 0};
  while (Real().poll(&wake, 1, -1) < 0 && errno == EINTR) {
  }
  EndToWait(waiter);
  std::uint64_t once = 0;
  if (Real().read(waiter->wake, &once, sizeof once) < 0) _exit(kLostTwin);
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
  constexpr std::int64_t kNsPerS = 1'000'000'000, kNsPerMs = 1'000'000;
  timespec now = {};
  if ((flags & TIMER_ABSTIME) != 0) Real().clock_gettime(clock, &now);
  const std::int64_t by_ns =
      (time->tv_sec - now.tv_sec) * kNsPerS + time->tv_nsec - now.tv_nsec;
  if (by_ns > 0) Sleep((by_ns + kNsPerMs - 1) / kNsPerMs * kNsPerMs);
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
  std::memcpy(all, polled, num * sizeof(pollfd));
  all[num] = {.fd = waiter->wake, .events = POLLIN, .revents = 0};
  {
    const Guarded guarded;
    std::memcpy(waiter->polled, polled, num * sizeof(pollfd));
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
  if (is_on) {
    const Guarded guarded;
    for (Waiter* one = waiters; one != nullptr; one = one->next) {
      const bool wakes =
          one->is_waiting && !one->is_woken && one->condition == condition;
      if (!wakes) continue;
      one->is_woken = true;
      ++num_working;
    }
  }
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
  Newcomer* place = nullptr;
  if (is_on) {
    const Guarded guarded;
    for (Newcomer& one : newcomers) {
      if (one.begun_ns == 0 && place == nullptr) place = &one;
    }
    if (place != nullptr) *place = {ComputerTime(), false, function, argument};
  }
  if (place == nullptr)
    return Real().thread_create(thread, attributes, function, argument);
  const int code = Real().thread_create(thread, attributes, BeginThread, place);
  if (code != 0) place->begun_ns = 0;
  return code;
}

int sem_wait(sem_t* semaphore) {
  if (as_newcomer != nullptr) as_newcomer->has_paused = true;
  return Real().sem_wait(semaphore);
}

int sem_clockwait(sem_t* semaphore, clockid_t clock, const timespec* until) {
  if (as_newcomer != nullptr) as_newcomer->has_paused = true;
  return Real().sem_clockwait(semaphore, clock, until);
}

pid_t fork() {
  const pid_t child = Real().fork();
  if (!is_on || child <= 0) return child;
  const Guarded guarded;
  for (pid_t& place : children) {
    if (place != 0) continue;
    place = child;
    break;
  }
  return child;
}

}  // extern "C"
