#include "tools/controllers/host_threads.h"

#include <cerrno>
#include <cstdlib>

#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace caltwin::host_time {

std::atomic<bool> is_on{false};
std::atomic<std::int64_t> now_ns{klipper::kHostStart_ns};
std::atomic<std::int64_t> written_bytes{0}, read_bytes{0};
std::atomic<int> line = -1;
thread_local Newcomer* as_newcomer = nullptr;

namespace {

using klipper::Grant;
using klipper::HostWaits;

constexpr int kMostChildren = 64, kMostNewcomers = 64;

int twin = -1;  // The socket.

// All below are guarded by `guard`.
pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;
pthread_cond_t all_wait = PTHREAD_COND_INITIALIZER;
Waiter* waiters = nullptr;
int num_working = 0;
std::int64_t sent_bytes = 0;  // To the host, as the twin said.
pid_t children[kMostChildren] = {};
Newcomer newcomers[kMostNewcomers];

pthread_key_t at_thread_end;
thread_local Waiter* own = nullptr;

// [ns]
std::int64_t ComputerTime() {
  timespec now = {};
  Real().clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

// The thread is a newcomer no more; guarded.
void Arrive() {
  if (as_newcomer == nullptr) return;
  as_newcomer->begun_ns = 0;
  as_newcomer = nullptr;
}

// Whether a newcomer is waited for: while it runs, however busy the computer is, and a
// moment of a pause, which may be no more than a lock.
bool IsAnyNewcomer() {
  constexpr std::int64_t kPause_ns = 50'000'000, kLongest_ns = 2'000'000'000;
  const std::int64_t now = ComputerTime();
  for (Newcomer& one : newcomers) {
    if (one.begun_ns == 0 || one.is_unseen) continue;
    const std::int64_t longest_ns = one.is_paused ? kPause_ns : kLongest_ns;
    if (now < one.begun_ns + longest_ns) return true;
    one.is_unseen = true;
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

}  // namespace

Guarded::Guarded() {
  pthread_mutex_lock(&guard);
}

Guarded::~Guarded() {
  pthread_mutex_unlock(&guard);
}

Waiter* Own() {
  if (own != nullptr) return own;
  own = new Waiter;
  own->wake = eventfd(0, EFD_CLOEXEC);
  pthread_setspecific(at_thread_end, own);
  // At once: in between nobody would know of it, and time would go on without it.
  const Guarded guarded;
  Arrive();
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

bool EndToWait(Waiter* waiter) {
  const Guarded guarded;
  if (!waiter->is_woken) ++num_working;
  waiter->is_waiting = false;
  waiter->num_polled = 0;
  waiter->condition = nullptr;
  return waiter->is_woken;
}

void WakeThoseAt(pthread_cond_t* condition) {
  const Guarded guarded;
  for (Waiter* one = waiters; one != nullptr; one = one->next) {
    const bool wakes = one->is_waiting && !one->is_woken && one->condition == condition;
    if (!wakes) continue;
    one->is_woken = true;
    ++num_working;
  }
}

Newcomer* ComeIn(void* (*function)(void*), void* argument) {
  const Guarded guarded;
  for (Newcomer& one : newcomers) {
    if (one.begun_ns != 0) continue;
    one = {.begun_ns = ComputerTime(), .function = function, .argument = argument};
    return &one;
  }
  return nullptr;
}

void* BeginThread(void* as) {
  as_newcomer = static_cast<Newcomer*>(as);
  void* const result = as_newcomer->function(as_newcomer->argument);
  const Guarded guarded;
  Arrive();
  return result;
}

void Pausing::Note(bool is_paused) {
  if (as_newcomer == nullptr) return;
  const Guarded guarded;
  as_newcomer->is_paused = is_paused;
  as_newcomer->begun_ns = ComputerTime();
}

void NoteChild(pid_t child) {
  const Guarded guarded;
  for (pid_t& place : children) {
    if (place != 0) continue;
    place = child;
    return;
  }
}

// ---- The thread that asks for time

namespace {

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
  const char* const number = getenv(klipper::kHostTimeVariable);
  if (number == nullptr) return;
  twin = atoi(number);
  // Not for the programs that the host runs.
  unsetenv(klipper::kHostTimeVariable);
  unsetenv("LD_PRELOAD");
  pthread_key_create(&at_thread_end, NoteThreadEnd);
  pthread_atfork(nullptr, nullptr, [] { is_on = false; });
  Own();  // The first thread works from the beginning.
  is_on = true;
  pthread_t thread;
  Real().thread_create(&thread, nullptr, AskAlways, nullptr);
  pthread_detach(thread);
}

}  // namespace
}  // namespace caltwin::host_time
