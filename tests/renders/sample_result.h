#pragma once

#include <cstdint>

#include "scenarios/result.h"
#include "sim/base/rng.h"

namespace caltwin {
inline ParameterResult Recovered(const char* name,
                                 const char* unit,
                                 double injected,
                                 double error,
                                 double sd,
                                 double tolerance) {
  return {.name = name,
          .unit = unit,
          .injected = injected,
          .recovered = injected + error,
          .sd = sd,
          .error = error,
          .tolerance = tolerance,
          .passed = true,
          .identifiable = true,
          .is_setting = true};
}

inline void AddTouches(RunResult* result,
                       const char* feature,
                       double nx,
                       double value_mm) {
  Rng rng(7, 0, feature);
  for (int i = 0; i < 20; ++i) {
    const auto number = static_cast<std::int64_t>(result->rows.rows.size() + 1);
    result->rows.rows.push_back({.row = number,
                                 .campaign = "next",
                                 .kind = RowKind::kTouch,
                                 .dir = {-nx, 0, 0},
                                 .n = {nx, 0, 0},
                                 .feature = feature,
                                 .value_mm = value_mm + 0.001 * rng.Normal()});
  }
}

/// A run as it might have been: two passes of dual-dimension steps/mm on x, backlash,
/// a pre-travel that cannot be told, touches of two faces; made up, the same each time.
inline RunResult SampleResult() {
  RunResult result{
      .scenario = "scenarios/first_light.yaml",
      .about = "A router with hidden errors finds them by touching a block.",
      .verbatim = "about: A router with hidden errors.\nseed: 1\n",
      .machine = "gantry_router",
      .passed = true,
      .outcome = "recovers",
      .fidelity = "physics"};
  result.parameters = {Recovered("steps_per_mm.x", "1/mm", 800, 0.011, 0.012, 0.08),
                       Recovered("backlash.x", "mm", 0.05, -0.0003, 0.0004, 0.002),
                       {.name = "probe_pretravel.z", .unit = "mm", .injected = 0.02}};
  result.checks = {{.name = "position_error_mm.p95",
                    .expected = "below 0.02",
                    .found = "0.0041",
                    .passed = true}};
  result.steps = {{.procedure = "next_dual_dimension",
                   .variant = "corrected",
                   .iteration = 1,
                   .name = "steps_per_mm.x",
                   .before = 808,
                   .after = 800.4,
                   .verdict = Verdict::kApplied,
                   .message = "The block measured 1.0 % too long."},
                  {.procedure = "next_dual_dimension",
                   .variant = "corrected",
                   .iteration = 2,
                   .name = "steps_per_mm.x",
                   .before = 800.4,
                   .after = 800.011,
                   .verdict = Verdict::kApplied,
                   .message = "Within its uncertainty."},
                  {.procedure = "next_cluster_backlash",
                   .variant = "corrected",
                   .iteration = 1,
                   .name = "backlash.x",
                   .before = 0,
                   .after = 0.0497,
                   .verdict = Verdict::kApplied,
                   .message = ""}};
  result.observability = {
      {.statement = "probe_pretravel.z + the height of the datum only",
       .blind_direction = {{"probe_pretravel.z", 1.0}}}};
  result.messages = {"Scatter of phase 3 is 1.0 um: within 5 um."};
  result.position_error_before_p95_mm = 1.43;
  result.position_error_after_p95_mm = 0.0041;
  result.machine_time_s = 512;
  result.cpu_s = 0.4;
  result.touches = 40;
  AddTouches(&result, "block.left", -1, 0.031);
  AddTouches(&result, "block.right", 1, -0.022);
  return result;
}

}  // namespace caltwin
