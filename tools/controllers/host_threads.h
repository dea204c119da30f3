#pragma once

#include <atomic>
#include <cstdint>

#include <poll.h>
#include <pthread.h>
#include <sys/types.h>

#include "sim/controllers/klipper/host_time.h"
#include "tools/controllers/real_calls.h"

namespace caltwin::host_time {

inline constexpr std::int64_t kNever = INT64_MAX;
inline constexpr int kLostTwin = 9;     // The host's exit code where the twin is gone.
inline constexpr int kMostPolled = 64;  // Descriptors of one call.

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

// A thread that has begun and has not yet waited where it is seen: it may be about to.
struct Newcomer {
  std::int64_t begun_ns = 0;  // Or last went on; by the computer's clock; 0: nobody.
  bool is_paused = false;     // For another thread of the host: it may stay unseen.
  bool is_unseen = false;     // It has stayed so, and is nobody's concern.
  void* (*function)(void*) = nullptr;
  void* argument = nullptr;
};
// Whether the host has the twin's time at all: a process that it forks has not.
extern std::atomic<bool> is_on;
extern std::atomic<std::int64_t> now_ns;
// On the line, in all.
extern std::atomic<std::int64_t> written_bytes, read_bytes;
extern std::atomic<int> line;  // The terminal, once the C helper has used it.
extern thread_local Newcomer* as_newcomer;

// The thread's own, made when it first waits.
Waiter* Own();
// It works no longer until EndToWait, which says whether it was woken by time or by a
// condition. What it waits for is filled in before, guarded.
void BeginToWait(Waiter* waiter);
bool EndToWait(Waiter* waiter);
// Whoever waits for that condition works again from now on.
void WakeThoseAt(pthread_cond_t* condition);

// A place for a thread that is about to be made, and what it then runs; null: there is
// none left.
Newcomer* ComeIn(void* (*function)(void*), void* argument);
void* BeginThread(void* newcomer);
// While it lives a newcomer waits for another thread of the host.
class Pausing {
 public:
  Pausing() { Note(true); }
  ~Pausing() { Note(false); }
  Pausing(const Pausing&) = delete;
  Pausing& operator=(const Pausing&) = delete;

 private:
  static void Note(bool is_paused);
};
// A process that the host has forked.
void NoteChild(pid_t child);

// Nobody begins or ends to wait meanwhile.
class Guarded {
 public:
  Guarded();
  ~Guarded();
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;
};

}  // namespace caltwin::host_time
