// What a triple-Z printer may have wrong: each in the truth code's own words.

#include <cmath>
#include <utility>

#include "tests/blind/triple_z/case.h"

namespace blind {
namespace {

const std::vector<std::string> kScrews = {"z1", "z2", "z3"};

std::size_t Screw(const std::string& axis) {
  return static_cast<std::size_t>(axis[1] - '1');
}

// Each named screw follows the command of the one before it.
void SwapMotors(const std::string& axis, double, double, TzTruth* truth) {
  int before = axis[axis.size() - 1] - '1';
  for (std::size_t at = 1; at < axis.size(); at += 2) {
    const int screw = axis[at] - '1';
    truth->driver[static_cast<std::size_t>(screw)] = before;
    before = screw;
  }
}

std::vector<TzCause> Screws() {
  return {{.name = "screw_pitch",
           .axes = kScrews,
           .typical = 300,
           .put =
               [](const std::string& axis, double size, double, TzTruth* truth) {
                 truth->pitch[Screw(axis)] += 1e-6 * size;
               },
           .parameter = "error_ppm"},
          {.name = "screw_cyclic",
           .axes = kScrews,
           .typical = 15,
           .put =
               [](const std::string& axis, double size, double second, TzTruth* truth) {
                 truth->wave_mm[Screw(axis)] += 1e-3 * size;
                 truth->wave_phase[Screw(axis)] = 3 * std::sin(9 * second);
                 truth->wave_length_mm[Screw(axis)] *= 1 + 0.004 * std::cos(9 * second);
               },
           .parameter = "amplitude_um",
           .is_positive = true},
          {.name = "screw_backlash",
           .axes = kScrews,
           .typical = 0.05,
           .put =
               [](const std::string& axis, double size, double, TzTruth* truth) {
                 truth->gap_mm[Screw(axis)] += size;
               },
           .parameter = "gap_mm",
           .is_positive = true},
          {.name = "pivot_position",
           .axes = kScrews,
           .typical = 15,
           .put =
               [](const std::string& axis, double size, double second, TzTruth* truth) {
                 truth->off_x_mm[Screw(axis)] += size;
                 truth->off_y_mm[Screw(axis)] += second;
               },
           .parameter = "dx_mm",
           .second = "dy_mm"},
          {.name = "motors_swapped",
           .axes = {"z1z2", "z1z3", "z2z3", "z1z2z3", "z1z3z2"},
           .typical = 1,
           .put = SwapMotors,
           .is_whole = true},
          {.name = "missed_steps",
           .axes = kScrews,
           .typical = 100,
           .put =
               [](const std::string& axis, double size, double second, TzTruth* truth) {
                 truth->jump_mm[Screw(axis)] += 1e-3 * size;
                 truth->jump_at_s = 1500 + 500 * second / (1 + std::abs(second));
               },
           .parameter = "jump_um"}};
}

TzCause Guides() {
  return {.name = "overconstrained_bed",
          .axes = {""},
          .typical = 1500,
          .put =
              [](const std::string&, double size, double, TzTruth* truth) {
                truth->held_mm2 += size;
              },
          .parameter = "stiffness_ratio_mm2",
          .is_positive = true};
}

std::vector<TzCause> Bed() {
  return {{.name = "bed_bowl",
           .axes = {""},
           .typical = 100,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->bowl_mm += 1e-3 * size;
               },
           .parameter = "height_um"},
          {.name = "bed_cylinder",
           .axes = {"x", "y"},
           .typical = 100,
           .put =
               [](const std::string& axis, double size, double, TzTruth* truth) {
                 (axis == "x" ? truth->along_x_mm : truth->along_y_mm) += 1e-3 * size;
               },
           .parameter = "height_um"},
          {.name = "bed_twist",
           .axes = {""},
           .typical = 100,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->twist_mm += 1e-3 * size;
               },
           .parameter = "height_um"},
          {.name = "trigger_latency",
           .axes = {""},
           .typical = 0.5,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->latency_s += 1e-3 * size;
               },
           .parameter = "latency_ms",
           .is_positive = true},
          {.name = "dent",
           .axes = {""},
           .typical = 0.1,
           .put =
               [](const std::string&, double size, double second, TzTruth* truth) {
                 truth->dent_mm += size;
                 truth->dent_x_mm += 30 * std::sin(second);
                 truth->dent_y_mm += 30 * std::cos(second);
               },
           .is_outside = true,
           .covariates = {"x", "y"}},
          {.name = "sticky_guide",
           .axes = {""},
           .typical = 0.1,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->sticky_mm += size;
               },
           .is_outside = true}};
}

std::vector<TzCause> Gantry() {
  return {{.name = "gantry_sag",
           .axes = {""},
           .typical = 60,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->sag_mm += 1e-3 * size;
               },
           .parameter = "sag_um"},
          {.name = "axis_twist",
           .axes = {""},
           .typical = 2,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->nod += 1e-3 * size;
               },
           .parameter = "twist_mrad"},
          {.name = "straightness",
           .axes = {"EZY"},
           .typical = 60,
           .put =
               [](const std::string&, double size, double, TzTruth* truth) {
                 truth->rail_mm += 1e-3 * size;
               },
           .parameter = "bow_um"},
          {.name = "angular",
           .axes = {"EAZ", "EBZ", "EBY"},
           .typical = 300,
           .put =
               [](const std::string& axis, double size, double, TzTruth* truth) {
                 double& turn = axis == "EAZ"   ? truth->lean_y
                                : axis == "EBZ" ? truth->lean_x
                                                : truth->roll;
                 turn += 1e-6 * size;
               },
           .parameter = "slope_urad"}};
}

}  // namespace

const std::vector<TzCause>& TzCauses() {
  static const std::vector<TzCause> causes = [] {
    std::vector<TzCause> all = Screws();
    all.push_back(Guides());
    for (TzCause& cause : Bed()) all.push_back(cause);
    for (TzCause& cause : Gantry()) all.push_back(cause);
    return all;
  }();
  return causes;
}

}  // namespace blind
