/* What LinuxCNC's component and caltwin share: a page of memory in a file that both
 * map. Plain C, since the component is. Whoever changes it raises kCaltwinPageVersion.
 *
 * A cycle of LinuxCNC's servo thread: the component writes `commanded_steps` and
 * `time_s`, raises `asked` by one and waits until `answered` is the same; the twin then
 * has moved its motors there and written all that stands below `answered`. Both numbers
 * are futex words; they wrap round. */
#ifndef CALTWIN_PAGE_H
#define CALTWIN_PAGE_H

#include <stdint.h>

enum {
  kCaltwinPageMagic = 0x4e435443,
  kCaltwinPageVersion = 1,
  kCaltwinPageJoints = 9,
  kCaltwinPageBytes = 4096
};

struct CaltwinPage {
  /* Written by the twin, once. */
  uint32_t magic, version;
  /* So long the component waits for an answer before it takes the twin for dead; 0: for
   * ever. */
  uint32_t patience_ms;
  /* 1 while the twin is there, 0 after it has ended. */
  uint32_t is_served;

  /* Written by the component. */
  uint32_t asked;
  double time_s; /* Cycles times period. */
  double commanded_steps[kCaltwinPageJoints];

  /* Written by the twin. */
  uint32_t answered;
  /* A bit a joint: its switch is closed. */
  uint32_t switches;
  uint32_t has_met; /* 1: the probe has met something. */
  double feedback_steps[kCaltwinPageJoints];
};

#endif
