// What a delta may have wrong: each in the truth code's own words.

#include <cmath>
#include <numbers>

#include "tests/blind/delta/case.h"

namespace blind {
namespace {

const std::vector<std::string> kTowers = {"a", "b", "c"};

std::size_t Tower(const std::string& axis) {
  return static_cast<std::size_t>(axis[0] - 'a');
}

void Rods(const std::string& axis, double size, double, DeltaTruth* truth) {
  const std::size_t first = 2 * Tower(axis);
  if (axis.size() < 2 || axis[1] == '1') truth->made.rod_mm[first] += size;
  if (axis.size() < 2 || axis[1] == '2') truth->made.rod_mm[first + 1] += size;
}

void Lean(const std::string& axis, double size, double second, DeltaTruth* truth) {
  truth->made.lean_out[Tower(axis)] += 1e-3 * size;
  truth->made.lean_round[Tower(axis)] += 1e-3 * second;
}

// What its parts have wrong.
std::vector<DeltaCause> Parts() {
  return {{"rod_mismatch",
           {"a", "b", "c", "a1", "a2", "b1", "b2", "c1", "c2"},
           0.1,
           Rods,
           "length_error_mm"},
          {"tower_lean", kTowers, 2, Lean, "radial_mrad", "tangential_mrad"},
          {"tower_twist",
           kTowers,
           0.5,
           [](const std::string& axis, double size, double, DeltaTruth* truth) {
             truth->made.twist[Tower(axis)] += size * std::numbers::pi / 180;
           },
           "angle_deg"},
          {"belt_pitch",
           kTowers,
           300,
           [](const std::string& axis, double size, double, DeltaTruth* truth) {
             truth->made.belt[Tower(axis)] += 1e-6 * size;
           },
           "error_ppm"},
          {"carriage_backlash",
           kTowers,
           0.05,
           [](const std::string& axis, double size, double, DeltaTruth* truth) {
             truth->gap_mm[Tower(axis)] += std::abs(size);
           },
           "gap_mm"}};
}

// What its bed, time and probe do.
std::vector<DeltaCause> Surroundings() {
  return {
      {"bed_bowl",
       {""},
       100,
       [](const std::string&, double size, double, DeltaTruth* truth) {
         truth->bed.bowl_mm += 1e-3 * size;
       },
       "height_um"},
      {"bed_cylinder",
       {"x", "y"},
       100,
       [](const std::string& axis, double size, double, DeltaTruth* truth) {
         (axis == "x" ? truth->bed.along_x_mm : truth->bed.along_y_mm) += 1e-3 * size;
       },
       "height_um"},
      {"bed_twist",
       {""},
       100,
       [](const std::string&, double size, double, DeltaTruth* truth) {
         truth->bed.twist_mm += 1e-3 * size;
       },
       "height_um"},
      {"missed_steps",
       kTowers,
       100,
       [](const std::string& axis, double size, double second, DeltaTruth* truth) {
         truth->jump_mm[Tower(axis)] += 1e-3 * size;
         truth->jump_at_s = 1500 + 500 * second / (1 + std::abs(second));
       },
       "jump_um"},
      {"frame_temperature",
       {"frame", "bed"},
       5,
       [](const std::string& axis, double size, double, DeltaTruth* truth) {
         (axis == "frame" ? truth->frame_mm_per_k : truth->bed_mm_per_k) += 1e-3 * size;
       },
       "growth_um_per_k"},
      {"trigger_latency",
       {""},
       0.5,
       [](const std::string&, double size, double, DeltaTruth* truth) {
         truth->latency_s += 1e-3 * std::abs(size);
       },
       "latency_ms"}};
}

std::vector<DeltaCause> Outside() {
  return {{"bowed_tower",
           kTowers,
           0.2,
           [](const std::string& axis, double size, double, DeltaTruth* truth) {
             truth->made.bow_mm[Tower(axis)] += size;
           },
           "",
           "",
           {"x", "y", "z", "motor_a", "motor_b", "motor_c"},
           true},
          {"slack_rods",
           kTowers,
           0.1,
           [](const std::string& axis, double size, double, DeltaTruth* truth) {
             truth->made.slack_mm[Tower(axis)] += size;
           },
           "",
           "",
           {"x", "y", "motor_a", "motor_b", "motor_c"},
           true},
          {"inductive_edge",
           {""},
           0.1,
           [](const std::string&, double size, double, DeltaTruth* truth) {
             truth->bed.edge_mm += size;
           },
           "",
           "",
           {"x", "y", "motor_a", "motor_b", "motor_c"},
           true},
          {"dent",
           {""},
           0.1,
           [](const std::string&, double size, double second, DeltaTruth* truth) {
             truth->bed.dent_mm += size;
             truth->bed.dent_x_mm = 0.3 * truth->bed.rim_mm * std::sin(second);
             truth->bed.dent_y_mm = 0.3 * truth->bed.rim_mm * std::cos(second);
             truth->bed.dent_radius_mm = 0.45 * truth->bed.rim_mm;
           },
           "",
           "",
           {"x", "y", "motor_a", "motor_b", "motor_c"},
           true}};
}

}  // namespace

const std::vector<DeltaCause>& DeltaCauses() {
  static const std::vector<DeltaCause> causes = [] {
    std::vector<DeltaCause> all = Parts();
    for (DeltaCause& cause : Surroundings()) all.push_back(cause);
    for (DeltaCause& cause : Outside()) all.push_back(cause);
    return all;
  }();
  return causes;
}

}  // namespace blind
