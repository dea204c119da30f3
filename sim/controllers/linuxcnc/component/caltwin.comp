component caltwin "The motors, switches and probe of a machine that caltwin simulates";
description """
Stands in place of a card with step generators. Once a servo cycle it tells caltwin where
LinuxCNC wants the joints, waits until the simulated machine has moved there, and reports
its switches and its probe: LinuxCNC and the machine are in lock-step, however slow the
machine is computed.

Put *caltwin.cycle* first into the servo thread, before the functions of motion.

Without caltwin it does not load. When caltwin has ended, or does not answer for as long as
it promised to, *enabled* goes false; wire it to iocontrol.0.emc-enable-in. It goes true
again when caltwin is back.""";
pin in float position-cmd-#[9] "as joint.N.motor-pos-cmd";
pin out float position-fb-#[9] "for joint.N.motor-pos-fb";
pin out bit home-sw-#[9] "the joint's switch is closed";
pin io bit index-enable-#[9] "as joint.N.index-enable: goes false where the motor passes an index pulse, from where position-fb then counts";
pin out bit probe "the probe has met something";
pin in bit enable = 1 "as iocontrol.0.user-enable-out";
pin out bit enabled "for iocontrol.0.emc-enable-in: enable, while caltwin answers";
pin out u32 missed "how often caltwin did not answer in time";
param rw float scale-#[9] = 1.0 "motor steps per machine unit, as of a step generator";
param rw float index-every-#[9] = 0 "motor steps from one index pulse to the next; 0: it has none";
option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
option homepage "docs/linuxcnc.md of caltwin";
function cycle fp;
license "GPL";
author "the authors of caltwin";
;;
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <rtapi_math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "page.h"

static char *page = "caltwin";
RTAPI_MP_STRING(page, "the name that caltwin serve --linuxcnc was given");

static char page_path[PATH_MAX];
static struct CaltwinPage *shared;
static double now_s;
static int is_lost;
/* Where each motor was a cycle ago, and the index pulse that it counts from. */
static double last_steps[kCaltwinPageJoints], index_steps[kCaltwinPageJoints];

static int refuse(const char *why) {
  rtapi_print_msg(RTAPI_MSG_ERR, "caltwin: %s: %s\n", page_path, why);
  return -EINVAL;
}

EXTRA_SETUP() {
  const char *own = getenv("CALTWIN_LINUXCNC_PAGE");
  struct stat file;
  int fd;
  snprintf(page_path, sizeof page_path, "%s%s", own ? "" : "/dev/shm/", own ? own : page);
  fd = open(page_path, O_RDWR | O_CLOEXEC);
  if (fd < 0 && errno != ENOENT) return refuse("cannot be opened");
  if (fd < 0) return refuse("no machine is served there; start caltwin serve --linuxcnc first");
  if (fstat(fd, &file) != 0 || file.st_size < (off_t)kCaltwinPageBytes) {
    close(fd);
    return refuse("this is no page of caltwin's");
  }
  shared = mmap(NULL, kCaltwinPageBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (shared == MAP_FAILED) return refuse("cannot be mapped");
  if (shared->magic != kCaltwinPageMagic) return refuse("this is no page of caltwin's");
  if (shared->version != kCaltwinPageVersion)
    return refuse("caltwin is of another version: compile the component again with halcompile");
  /* What an earlier LinuxCNC asked and never heard is not ours. */
  __atomic_store_n(&shared->asked, __atomic_load_n(&shared->answered, __ATOMIC_ACQUIRE),
                   __ATOMIC_RELEASE);
  return 0;
}

EXTRA_CLEANUP() {
  if (shared == NULL || shared == MAP_FAILED) return;
  /* A twin that was killed leaves its page behind. */
  if (is_lost && !getenv("CALTWIN_LINUXCNC_PAGE")) unlink(page_path);
  munmap(shared, kCaltwinPageBytes);
}

static int is_answered(void) {
  return __atomic_load_n(&shared->answered, __ATOMIC_ACQUIRE) ==
         __atomic_load_n(&shared->asked, __ATOMIC_RELAXED);
}

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Whether the twin has answered, waiting for it as long as it promised. */
static int await(void) {
  const double until_s = seconds() + 1e-3 * shared->patience_ms;
  int spin;
  for (spin = 0; spin < 2000; ++spin) {
    if (is_answered()) return 1;
  }
  while (!is_answered()) {
    const struct timespec glance = {0, 100000000};
    const uint32_t seen = __atomic_load_n(&shared->answered, __ATOMIC_ACQUIRE);
    if (!__atomic_load_n(&shared->is_served, __ATOMIC_ACQUIRE)) return 0;
    if (shared->patience_ms != 0 && seconds() > until_s) return 0;
    if (seen == __atomic_load_n(&shared->asked, __ATOMIC_RELAXED)) return 1;
    syscall(SYS_futex, &shared->answered, FUTEX_WAIT, seen, &glance, NULL, 0);
  }
  return 1;
}

static void ask(void) {
  __atomic_fetch_add(&shared->asked, 1, __ATOMIC_RELEASE);
  syscall(SYS_futex, &shared->asked, FUTEX_WAKE, 1, NULL, NULL, 0);
}

/* The pulse between two places, the nearer to where the motor has come; is_passed: whether
   there is one. */
static double pulse(double from, double to, double every, int *is_passed) {
  const double behind = floor(from / every), now = floor(to / every);
  *is_passed = behind != now;
  return every * (to > from ? now : now + 1);
}

FUNCTION(cycle) {
  int i;
  /* What a lost twin was asked it has to answer before it is asked anew. */
  if (is_lost && !is_answered()) {
    enabled = 0;
    return;
  }
  now_s += 1e-9 * (double)period;
  for (i = 0; i < kCaltwinPageJoints; ++i)
    shared->commanded_steps[i] = position_cmd(i) * scale(i) + index_steps[i];
  shared->time_s = now_s;
  ask();
  is_lost = !await();
  enabled = enable && !is_lost;
  if (is_lost) {
    missed = missed + 1;
    rtapi_print_msg(RTAPI_MSG_ERR, "caltwin: the simulated machine does not answer\n");
    return;
  }
  for (i = 0; i < kCaltwinPageJoints; ++i) {
    const double steps = shared->feedback_steps[i];
    if (index_enable(i) && index_every(i) > 0) {
      int is_passed;
      const double at = pulse(last_steps[i], steps, index_every(i), &is_passed);
      if (is_passed) {
        index_steps[i] = at;
        index_enable(i) = 0;
      }
    }
    last_steps[i] = steps;
    position_fb(i) = scale(i) != 0 ? (steps - index_steps[i]) / scale(i) : 0;
    home_sw(i) = shared->switches >> i & 1;
  }
  probe = shared->has_met != 0;
}
