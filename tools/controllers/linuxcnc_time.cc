// Time for LinuxCNC, loaded into its processes: that of its own servo cycles, which go
// on as fast as the simulated machine answers them. Two of its programs are changed,
// and each in one call:
//
//   rtapi_app   sleeps until the next cycle is due: returns at once
//   milltask    reads the clock for dwells and time-outs: cycles times period, from the
//   page
//
// Without a page (CALTWIN_LINUXCNC_PAGE) nothing is changed.

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

#include "sim/controllers/linuxcnc/component/page.h"

namespace {

const CaltwinPage* Mapped() {
  const char* const path = std::getenv("CALTWIN_LINUXCNC_PAGE");
  if (path == nullptr) return nullptr;
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* const at = mmap(nullptr, kCaltwinPageBytes, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  return at == MAP_FAILED ? nullptr : static_cast<const CaltwinPage*>(at);
}

const CaltwinPage* Page() {
  static const CaltwinPage* const page = Mapped();
  return page;
}

bool Is(std::string_view program) {
  return program == program_invocation_short_name;
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int clock_nanosleep(clockid_t clock,
                    int flags,
                    const timespec* request,
                    timespec* remain) {
  static auto* const real =
      Real<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  static const bool is_ours = Is("rtapi_app") && Page() != nullptr;
  const bool is_absolute = (flags & TIMER_ABSTIME) != 0;
  return is_ours && is_absolute ? 0 : real(clock, flags, request, remain);
}

int gettimeofday(timeval* time, void* zone) {
  static auto* const real = Real<int(timeval*, void*)>("gettimeofday");
  static const bool is_ours = Is("milltask");
  if (!is_ours || Page() == nullptr) return real(time, zone);
  constexpr time_t kStart_s = 1'000'000'000;
  const double now_s = Page()->time_s;
  time->tv_sec = kStart_s + static_cast<time_t>(now_s);
  time->tv_usec = static_cast<suseconds_t>((now_s - std::floor(now_s)) * 1e6);
  return 0;
}
}
