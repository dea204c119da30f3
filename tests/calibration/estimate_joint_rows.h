#pragma once

#include <string>
#include <vector>

#include "calibration/estimate/joint.h"
#include "sim/base/rng.h"
#include "sim/effects/catalog.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin::joint_test {

/// A hidden X axis and probe, and rows of it written out by hand from the triggers
/// themselves (PROCEDURES, "Signs"): nothing of the effect library is in them.
struct Hidden {
  double true_steps = 795;
  double backlash_mm = 0.06;
  double pretravel_mm = 0.03;
  double radius_mm = 1.004;
  double hysteresis_mm = 0.002;
  double latency_s = 0.0003;
  double place_mm = 0.2;  ///< How far the block lies off its nominal place.
};

inline constexpr double kCfgSteps = 800;
inline constexpr double kCfgRadius_mm = 1.0;
inline constexpr double kSigma_mm = 0.001;

inline Machine Gantry() {
  Machine machine;
  for (AxisDrawing& axis : machine.axes) {
    axis.counterbalance_n = axis.moving_mass_kg * kGravity_m_s2;
  }
  machine.settings = {.steps_per_mm = {kCfgSteps, kCfgSteps, kCfgSteps},
                      .tip_radius_mm = kCfgRadius_mm};
  return machine;
}

/// A face of a block, touched (or released) along x.
struct Face {
  double at_mm = 0;  ///< Nominal.
  int normal = 1;    ///< Looks towards +x or -x.
  double feed_mm_s = 1;
  bool release = false;
  std::string setup = "block";
};

/// Steps are counted from home at 0: true position = commanded * s_cfg / s_true - dir *
/// b / 2. At the trigger the tip's centre stands R - delta in front of the face; the
/// machine then moves on for the latency.
inline Row TouchX(const Hidden& hidden,
                  const Face& face,
                  double noise_mm,
                  double steps = kCfgSteps) {
  const double n = face.normal;
  const double dir = face.release ? n : -n;
  const double deflection_mm =
      hidden.pretravel_mm - (face.release ? hidden.hysteresis_mm : 0);
  const double surface_mm = face.at_mm + hidden.place_mm;
  const double centre_mm = surface_mm + n * (hidden.radius_mm - deflection_mm) +
                           dir * face.feed_mm_s * hidden.latency_s;
  const double commanded_mm =
      (centre_mm + dir * hidden.backlash_mm / 2) / (steps / hidden.true_steps);
  Row row{.kind = RowKind::kTouch, .setup = face.setup};
  row.cmd_mm = {face.at_mm, 100, 20};
  row.n = {n, 0, 0};
  row.dir = {dir, 0, 0};
  row.feed_mm_s = face.feed_mm_s;
  row.feature = face.setup + (n > 0 ? ".right" : ".left");
  row.value_mm = (commanded_mm - face.at_mm) * n - kCfgRadius_mm + noise_mm;
  row.sigma_mm = kSigma_mm;
  return row;
}

/// Two sizes of one block, each face touched `repeats` times; with `release`, the left
/// faces released too, at two feeds.
inline RowTable Block(const Hidden& hidden,
                      int repeats,
                      bool release,
                      Rng* rng,
                      double sigma_mm = kSigma_mm) {
  RowTable table;
  const auto add = [&](const Face& face) {
    for (int i = 0; i < repeats; ++i) {
      table.rows.push_back(TouchX(hidden, face, sigma_mm * rng->Normal()));
    }
  };
  for (const double size_mm : {25.4, 76.2}) {
    const std::string setup = size_mm < 50 ? "short" : "long";
    for (const int normal : {-1, +1}) {
      add({.at_mm = 150 + normal * size_mm / 2, .normal = normal, .setup = setup});
      if (!release || normal > 0) continue;
      for (const double feed_mm_s : {1.0, 5.0}) {
        add({.at_mm = 150 - size_mm / 2,
             .normal = -1,
             .feed_mm_s = feed_mm_s,
             .setup = setup});
        add({.at_mm = 150 - size_mm / 2,
             .normal = -1,
             .feed_mm_s = feed_mm_s,
             .release = true,
             .setup = setup});
      }
    }
  }
  return table;
}

inline FreeParameter Steps() {
  return {.effect = EffectIndex<StepsPerMm>(), .axis = "x"};
}
inline FreeParameter Gap() {
  return {.effect = EffectIndex<Backlash>(), .axis = "x"};
}
inline FreeParameter Pretravel() {
  return {.effect = EffectIndex<ProbePretravel>(), .axis = "x"};
}
/// With a calliper's word on the ball: its true radius, known to `sd_mm`.
inline FreeParameter Tip(double radius_error_mm, double sd_mm) {
  return {.effect = EffectIndex<TipSize>(),
          .measured = Given{.value = radius_error_mm, .sd = sd_mm}};
}
inline FreeParameter Latency() {
  return {.effect = EffectIndex<TriggerLatency>()};
}

inline JointProblem Problem(const RowTable& table,
                            std::vector<FreeParameter> free,
                            const Hidden& hidden = {}) {
  const Machine machine = Gantry();
  return {
      .machine = machine,
      .free = std::move(free),
      .observations = ObservationsOf(table, machine, {.default_sigma_mm = kSigma_mm}),
      .nuisances = {
          {"probe_hysteresis", Given{.value = hidden.hysteresis_mm, .sd = 1e-5}}}};
}

}  // namespace caltwin::joint_test
