#include <fmt/format.h>

#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

// Beyond what any machine has, and any number of steps.
constexpr double kMostSteps = 1e6, kWidest_mm = 100;

}  // namespace

Reply Firmware::Parts::StepsPerMm(const Words& words) {
  Settings changed = settings;
  bool has_changed = false;
  for (const Axis axis : kAxes) {
    const auto steps_per_mm = words.Number(CapitalLetter(axis));
    if (!steps_per_mm) continue;
    if (*steps_per_mm <= 0) return Refuse("M92: steps/mm must be above 0");
    if (*steps_per_mm > kMostSteps)
      return Refuse("M92: steps/mm must be below 1000000");
    changed.steps_per_mm[Index(axis)] = *steps_per_mm;
    has_changed = true;
  }
  if (!has_changed) {
    return {.lines = {fmt::format("Steps/mm: X: {:.3f}, Y: {:.3f}, Z: {:.3f}",
                                  settings.steps_per_mm[0],
                                  settings.steps_per_mm[1],
                                  settings.steps_per_mm[2])}};
  }
  motion.Finish();
  if (motion.alarm()) return {};
  settings = changed;
  motion.KeepPosition();
  return {};
}

Reply Firmware::Parts::BacklashSettings(const Words& words) {
  Settings changed = settings;
  bool has_changed = false;
  for (const Axis axis : kAxes) {
    const auto gap_mm = words.Number(CapitalLetter(axis));
    if (!gap_mm) continue;
    if (*gap_mm < 0) return Refuse("M425: backlash must not be negative");
    if (*gap_mm > kWidest_mm) return Refuse("M425: backlash must be below 100 mm");
    changed.backlash_mm[Index(axis)] = *gap_mm;
    has_changed = true;
  }
  const auto factor = words.Number('S');
  if (factor && *factor < 1) return Refuse("M425: parameter 'S' must be at least 1");
  if (!has_changed && !factor) {
    return {.lines = {fmt::format("Backlash correction (mm): X: {:.3f}, Y: {:.3f}, Z: "
                                  "{:.3f}, correction distance factor {:g}",
                                  settings.backlash_mm[0],
                                  settings.backlash_mm[1],
                                  settings.backlash_mm[2],
                                  motion.backlash_factor())}};
  }
  motion.Finish();
  settings = changed;
  if (factor) motion.set_backlash_factor(*factor);
  return {};
}

Reply Firmware::Parts::SelectTool(const GcodeCommand& command) {
  if (command.code < -1 || command.code > 0) {
    return Refuse(fmt::format("T{}: there is no such tool", command.code));
  }
  motion.Finish();
  tool = command.code;
  return {};
}

}  // namespace caltwin
