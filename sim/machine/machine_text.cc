#include "sim/machine/machine_text.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr double kUsualFullSteps_per_rev = 200, kUsualMicrosteps = 16;

bool IsStated(double value) {
  return !std::isnan(value);
}

double FullSteps(const AxisSettingsText& axis) {
  return IsStated(axis.full_steps_per_rev) ? axis.full_steps_per_rev
                                           : kUsualFullSteps_per_rev;
}

double Microsteps(const AxisSettingsText& axis) {
  return IsStated(axis.microsteps) ? axis.microsteps : kUsualMicrosteps;
}

double Lead_mm(const AxisSettingsText& axis) {
  return FullSteps(axis) * Microsteps(axis) / axis.steps_per_mm;
}

std::string AxisYaml(char letter, const AxisSettingsText& axis, bool has_belt) {
  constexpr double kUsualTravel_mm = 200;
  const bool states_drive = IsStated(axis.microsteps);
  std::vector<std::string> more;
  if (states_drive) {
    more.push_back(fmt::format("full_steps_per_rev: {:g}", FullSteps(axis)));
    more.push_back(fmt::format("microsteps: {:g}", axis.microsteps));
  }
  if (axis.home) {
    more.emplace_back(*axis.home == HomeEnd::kMin ? "home: min" : "home: max");
  }
  if (IsStated(axis.max_feed_mm_s)) {
    more.push_back(fmt::format("max_feed_mm_s: {:.9g}", axis.max_feed_mm_s));
  }
  if (IsStated(axis.acceleration_mm_s2)) {
    more.push_back(fmt::format("acceleration_mm_s2: {:.9g}", axis.acceleration_mm_s2));
  }
  return fmt::format("  {}: {{min_mm: {:.9g}, max_mm: {:.9g}, {}: {:.9g}{}{}}}\n",
                     letter,
                     axis.min_mm,
                     IsStated(axis.max_mm) ? axis.max_mm : kUsualTravel_mm,
                     has_belt ? "pulley_mm_per_rev" : "lead_mm",
                     Lead_mm(axis),
                     more.empty() ? "" : ", ",
                     fmt::join(more, ", "));
}

std::string Comment(const CartesianMachineText& machine) {
  const auto all_state = [&](double AxisSettingsText::*value) {
    return std::ranges::all_of(machine.axes, [&](const AxisSettingsText& axis) {
      return IsStated(axis.*value);
    });
  };
  std::string drives;
  if (!all_state(&AxisSettingsText::full_steps_per_rev)) {
    drives =
        fmt::format(", taken for motors of 200 full steps{}",
                    all_state(&AxisSettingsText::microsteps) ? "" : " in sixteenths");
  }
  return fmt::format(
      "# From {}: steps/mm{}.{}\n",
      machine.source,
      drives,
      all_state(&AxisSettingsText::max_mm) ? "" : " Travels are not in it: put yours.");
}

std::string ScrewsYaml(const CartesianMachineText& machine) {
  if (machine.screws_mm.empty()) return "";
  const AxisSettingsText& z = machine.axes[2];
  std::string text = "screws:\n";
  for (std::size_t i = 0; i < machine.screws_mm.size(); ++i) {
    text += fmt::format(
        "  z{}: {{at_mm: [{:g}, {:g}], lead_mm: {:.9g}, full_steps_per_rev: {:g}, "
        "microsteps: {:g}}}\n",
        i + 1,
        machine.screws_mm[i][0],
        machine.screws_mm[i][1],
        Lead_mm(z),
        FullSteps(z),
        Microsteps(z));
  }
  return text;
}

}  // namespace

std::string CartesianMachineYaml(const CartesianMachineText& machine) {
  const bool has_screws = !machine.screws_mm.empty();
  std::string text = Comment(machine) +
                     fmt::format("format: 1\nname: {}\nkinematics: {}\n",
                                 machine.name,
                                 machine.is_corexy ? "corexy"
                                 : has_screws      ? "triple_z"
                                                   : "cartesian") +
                     ScrewsYaml(machine);
  if (!machine.corners_mm.empty()) {
    text += fmt::format("gantry: {{corners_mm: {}}}\n", machine.corners_mm);
  }
  if (machine.beam_mm) {
    text += fmt::format("beam: {{motors_at_x_mm: {}}}\n", *machine.beam_mm);
  }
  text += "axes:\n";
  std::vector<std::string> steps, gaps;
  const std::string_view motors = machine.is_corexy ? "abz" : "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisSettingsText& axis = machine.axes[i];
    text += AxisYaml("xyz"[i], axis, machine.has_belts && i < 2);
    // A bed on screws has no other drive of which a machine file states steps/mm.
    const bool is_own = !has_screws || machine.is_corexy || i == 2;
    if (is_own)
      steps.push_back(fmt::format("{}: {:.9g}", motors[i], axis.steps_per_mm));
    if (is_own && IsStated(axis.backlash_mm))
      gaps.push_back(fmt::format("{}: {:g}", motors[i], axis.backlash_mm));
  }
  return text + fmt::format("settings: {{steps_per_mm: {{{}}}{}}}\n",
                            fmt::join(steps, ", "),
                            gaps.empty() ? ""
                                         : fmt::format(", backlash_mm: {{{}}}",
                                                       fmt::join(gaps, ", ")));
}

}  // namespace caltwin
