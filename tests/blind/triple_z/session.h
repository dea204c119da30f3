#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tests/blind/random.h"

namespace blind {

using ByScrew = std::array<double, 3>;

/// A printer with a bed on three screws, as drawn.
struct TzPaper {
  ByScrew screw_x_mm{20, 215, 20}, screw_y_mm{20, 20, 215};
  double lead_mm = 4;
  double wide_mm = 235, deep_mm = 235;  ///< Travel of x and y, from 0.
  double high_mm = 250;                 ///< Of z: the screws there meet the nozzle.
};

/// One reading to be taken on it.
struct TzStop {
  std::string campaign{}, setup{}, feature{}, home = "1";
  bool is_touch = true;
  bool is_on_frame = false;  ///< A gauge that the gantry does not carry.
  double x_mm = 0, y_mm = 0;
  double z_mm = 0;      ///< Nozzle over the bed, commanded; 0 of touches.
  double off_y_mm = 0;  ///< Of the probe's tip.
  ByScrew raised_mm{};  ///< Each screw beyond what z has it.
  int bed_sense = 1;    ///< +1: the bed came up.
  double feed_mm_s = 5;
  double t_s = 0, frame_k = 0, bed_k = 0;
};

/// All that is true of such a printer in a session.
struct TzTruth {
  ByScrew off_x_mm{}, off_y_mm{};      ///< Where screws stand, less drawn.
  std::array<int, 3> driver{0, 1, 2};  ///< Which command each screw follows.
  ByScrew pitch{};                     ///< Further than told, of its height.
  ByScrew wave_mm{}, wave_phase{}, wave_length_mm{4, 4, 4};
  ByScrew gap_mm{};
  ByScrew jump_mm{};
  double jump_at_s = 1e9;
  /// Guides that turn the bed back: their stiffness over that of a screw's support.
  double held_mm2 = 0;
  double scale = 0, all_gap_mm = 0;
  /// The bed's surface over its balls, corners against middle, and its edges.
  double bowl_mm = 0, along_x_mm = 0, along_y_mm = 0, twist_mm = 0;
  double dent_mm = 0, dent_x_mm = 117, dent_y_mm = 117;
  /// The gantry: sag of the beam (ends against middle), bow of the rails, roll along y,
  /// nod along x, lean with z, all over the whole travel.
  double sag_mm = 0, rail_mm = 0, roll = 0, nod = 0, lean_x = 0, lean_y = 0;
  double sticky_mm = 0;  ///< Outside: the bed's guide jams high up.
  double latency_s = 0;
  double frame_mm_per_k = 0, bed_mm_per_k = 0;
  /// Per homing: height, slopes.
  std::function<std::array<double, 3>(const std::string& home)> plane{};
  std::function<double(const std::string& setup)> zero_mm{};
};

/// Its value without noise, as CONTRACT has it.
double ReadTz(const TzPaper& paper, const TzTruth& truth, const TzStop& stop);
/// What its screws are told for the commanded pose.
ByScrew ToldFor(const TzPaper& paper, const TzStop& stop);

/// @name Campaigns
void AddTzGrid(const TzPaper& paper, Random* random, std::vector<TzStop>* stops);
void AddTzHeights(const TzPaper& paper, Random* random, std::vector<TzStop>* stops);
void AddFixedPost(const TzPaper& paper, Random* random, std::vector<TzStop>* stops);
void AddOneByOne(const TzPaper& paper, Random* random, std::vector<TzStop>* stops);

}  // namespace blind
