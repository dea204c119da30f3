#include "tools/commands/starter.h"

#include <array>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr const char* kHead =
    "# {0}: sizes of your own machine. Lengths in mm, masses in kg, forces in N.\n"
    "# Check with `caltwin validate`.\n"
    "format: 1\n"
    "name: {0}\n"
    "kinematics: cartesian\n"
    "# model: model.xml      # an MJCF of your own; without it a plain one is built\n"
    "\n"
    "axes:\n";

constexpr const char* kAxis =
    "  {letter}:\n"
    "    min_mm: {min}          # the travel, in machine coordinates\n"
    "    max_mm: {max}\n"
    "    home: {home}            # the end with the limit switch: min or max\n"
    "    {lead_key}: {lead}         # travel per motor turn (belt: pulley_mm_per_rev)\n"
    "    full_steps_per_rev: {full}\n"
    "    microsteps: {micro}\n"
    "    max_feed_mm_s: {feed}\n"
    "    acceleration_mm_s2: {acceleration}\n"
    "    moving_mass_kg: {mass}    # all that this axis moves\n"
    "    rail_friction_n: {friction}   # force that keeps it just moving, drive "
    "detached\n";

constexpr const char* kCounterbalance =
    "    counterbalance_n: {}   # upward; its own weight, {:.4g} N, balances it "
    "fully\n";

constexpr const char* kProbe =
    "\n"
    "probe:\n"
    "  tip_radius_mm: {radius}        # the radius of the ball, not its diameter\n"
    "  pretravel_mm: {pretravel}        # stylus deflection at the trigger\n"
    "  hysteresis_mm: {hysteresis}      # and how much less of it releases\n"
    "  speeds_mm_s: [{speeds}]     # approach, measuring touch\n"
    "  overtravel_mm: {overtravel}          # deflection that bends the stylus\n"
    "  stiffness_n_per_mm: {stiffness}\n"
    "  disc_radius_mm: {disc}         # of the disc stylus, for ledges\n";

constexpr const char* kSettings =
    "\n"
    "settings:                   # what the firmware is configured with\n"
    "  steps_per_mm: {steps}   # full_steps_per_rev * microsteps / lead_mm\n"
    "  backlash_mm: {backlash}\n"
    "  probe_deflection_mm: {deflection}\n"
    "  tip_radius_mm: {radius}\n";

std::string AxisText(const Machine& machine, Axis axis) {
  const AxisDrawing& drawing = machine.axis(axis);
  std::string text = fmt::format(
      fmt::runtime(kAxis),
      fmt::arg("letter", Name(axis)),
      fmt::arg("min", drawing.min_mm),
      fmt::arg("max", drawing.max_mm),
      fmt::arg("home", drawing.home == HomeEnd::kMin ? "min" : "max"),
      fmt::arg("lead_key", drawing.is_belt ? "pulley_mm_per_rev" : "lead_mm"),
      fmt::arg("lead", drawing.lead_mm),
      fmt::arg("full", drawing.full_steps_per_rev),
      fmt::arg("micro", drawing.microsteps),
      fmt::arg("feed", drawing.max_feed_mm_s),
      fmt::arg("acceleration", drawing.acceleration_mm_s2),
      fmt::arg("mass", drawing.moving_mass_kg),
      fmt::arg("friction", drawing.rail_friction_n));
  if (axis == Axis::kZ) {
    text += fmt::format(fmt::runtime(kCounterbalance),
                        drawing.counterbalance_n,
                        drawing.moving_mass_kg * kGravity_m_s2);
  }
  return text;
}

std::string ByAxis(const std::array<double, 3>& values) {
  return fmt::format("{{x: {}, y: {}, z: {}}}", values[0], values[1], values[2]);
}

}  // namespace

std::string StarterText(const Machine& like, const std::string& name) {
  std::string text = fmt::format(fmt::runtime(kHead), name);
  for (const Axis axis : kAxes) text += AxisText(like, axis);
  text += fmt::format(
      fmt::runtime(kProbe),
      fmt::arg("radius", like.probe.tip_radius_mm),
      fmt::arg("pretravel", like.probe.pretravel_mm),
      fmt::arg("hysteresis", like.probe.hysteresis_mm),
      fmt::arg("speeds", fmt::format("{}", fmt::join(like.probe.speeds_mm_s, ", "))),
      fmt::arg("overtravel", like.probe.overtravel_mm),
      fmt::arg("stiffness", like.probe.stiffness_n_per_mm),
      fmt::arg("disc", like.probe.disc_radius_mm));
  return text +
         fmt::format(fmt::runtime(kSettings),
                     fmt::arg("steps", ByAxis(like.settings.steps_per_mm)),
                     fmt::arg("backlash", ByAxis(like.settings.backlash_mm)),
                     fmt::arg("deflection", ByAxis(like.settings.probe_deflection_mm)),
                     fmt::arg("radius", like.settings.tip_radius_mm));
}

std::string StarterLike(const std::string& text, const std::string& name) {
  std::string starter = fmt::format(
      "# {}: sizes of your own machine. Check with `caltwin validate`.\n", name);
  std::istringstream lines(text);
  bool is_head = true;
  for (std::string line; std::getline(lines, line);) {
    is_head = is_head && line.starts_with('#');  // Of the machine that it is like.
    if (is_head) continue;
    if (line.starts_with("name:")) {
      line = "name: " + name;
    } else if (line.starts_with("model:")) {
      line =
          "# " + line + "      # an MJCF of your own; without it a plain one is built";
    }
    starter += line + "\n";
  }
  return starter;
}

}  // namespace caltwin
