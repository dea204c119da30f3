#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/blind/delta/parts.h"
#include "tests/blind/random.h"

namespace blind {

/// One reading to be taken on a delta.
struct DeltaStop {
  std::string campaign{}, setup{}, feature{};
  bool is_touch = true;
  Vec at_mm = Vec::Zero();  ///< Commanded pose, or nominal touched point.
  Vec n{0, 0, 1};
  Vec from_mm{0, 0, 5};  ///< Where it comes from, less `at_mm`.
  double feed_mm_s = 5;
  double t_s = 0;
  double frame_k = 0, bed_k = 0, screw_k = 0;  ///< Temperatures less the first.
};

/// The bed under a delta, heights over its rim's radius R.
struct DeltaSurface {
  double slope_x = 0, slope_y = 0;
  double bowl_mm = 0, along_x_mm = 0, along_y_mm = 0, twist_mm = 0;
  /// Real plates bend a little otherwise than parabolas do: r to this power.
  double power = 2;
  double rim_mm = 100;
  /// Outside every catalogue: a dent, and metal near the edge that pulls an inductive
  /// probe's trigger.
  double dent_mm = 0, dent_x_mm = 0, dent_y_mm = 0, dent_radius_mm = 30;
  double edge_mm = 0, edge_from = 0.8;
  double Height_mm(double x_mm, double y_mm) const;
};

/// All that is true of a delta in a session.
struct DeltaTruth {
  DeltaMade made{};
  DeltaSurface bed{};
  ByTower gap_mm{};                 ///< Of carriages.
  std::array<double, 3> jump_mm{};  ///< Of carriages (+ down), from `jump_at_s` on.
  double jump_at_s = 1e9;
  double frame_mm_per_k = 0, bed_mm_per_k = 0, probe_mm_per_k = 0;
  double latency_s = 0;
  /// Of each setup: where it stands, and its turn about the vertical.
  std::function<Vec(const std::string& setup)> offset_mm{};
  std::function<double(const std::string& setup)> turn{};
};

/// The sense in which each carriage last moved (+1 down): from where it came.
ByTower SensesOf(const DeltaPaper& paper, const DeltaStop& stop);

/// Its value without noise, as CONTRACT has it; empty: out of reach.
std::optional<double> ReadStop(const DeltaPaper& paper,
                               const DeltaTruth& truth,
                               const DeltaStop& stop);

/// Campaigns.
void AddDeltaGrid(const DeltaPaper& paper,
                  Random* random,
                  std::vector<DeltaStop>* stops);
void AddDeltaRing(const DeltaPaper& paper,
                  Random* random,
                  std::vector<DeltaStop>* stops);
void AddDeltaXy(const DeltaPaper& paper, Random* random, std::vector<DeltaStop>* stops);
void AddZColumns(const DeltaPaper& paper,
                 Random* random,
                 std::vector<DeltaStop>* stops);

}  // namespace blind
