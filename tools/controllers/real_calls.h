#pragma once

#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/types.h>
#include <time.h>

namespace caltwin::host_time {

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
inline const RealCalls& Real() {
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

}  // namespace caltwin::host_time
