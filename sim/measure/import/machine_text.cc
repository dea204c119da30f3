#include "sim/measure/import/machine_text.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr double kFullSteps_per_rev = 200, kUsualMicrosteps = 16;

double Microsteps(const AxisText& axis) {
  return Known(axis.microsteps) ? axis.microsteps : kUsualMicrosteps;
}

std::string AxisYaml(char letter, const AxisText& axis) {
  constexpr double kUsualTravel_mm = 200;
  const double length_mm = kFullSteps_per_rev * Microsteps(axis) / axis.steps_per_mm;
  const std::string drive =
      Known(axis.microsteps)
          ? fmt::format(", full_steps_per_rev: {:g}, microsteps: {:g}",
                        kFullSteps_per_rev,
                        axis.microsteps)
          : "";
  return fmt::format("  {}: {{min_mm: {:g}, max_mm: {:g}, {}: {:.9g}{}}}\n",
                     letter,
                     axis.min_mm,
                     Known(axis.max_mm) ? axis.max_mm : kUsualTravel_mm,
                     letter == 'z' ? "lead_mm" : "pulley_mm_per_rev",
                     length_mm,
                     drive);
}

}  // namespace

std::string CartesianMachineYaml(const CartesianMachineText& machine) {
  const bool has_screws = !machine.screws_mm.empty();
  const bool states_drives = std::ranges::all_of(
      machine.axes, [](const AxisText& axis) { return Known(axis.microsteps); });
  const bool states_travels = std::ranges::all_of(
      machine.axes, [](const AxisText& axis) { return Known(axis.max_mm); });
  std::string text = fmt::format(
      "# From {}: steps/mm, taken for motors of 200 full steps{}.{}\nformat: 1\nname: "
      "{}\nkinematics: {}\n",
      machine.source,
      states_drives ? "" : " in sixteenths",
      states_travels ? "" : " Travels are not in it: put yours.",
      machine.name,
      machine.is_corexy ? "corexy"
      : has_screws      ? "triple_z"
                        : "cartesian");
  const AxisText& z = machine.axes[2];
  const double lead_mm = kFullSteps_per_rev * Microsteps(z) / z.steps_per_mm;
  if (has_screws) text += "screws:\n";
  for (std::size_t i = 0; i < machine.screws_mm.size(); ++i) {
    text += fmt::format(
        "  z{}: {{at_mm: [{:g}, {:g}], lead_mm: {:.9g}, full_steps_per_rev: {:g}, "
        "microsteps: {:g}}}\n",
        i + 1,
        machine.screws_mm[i][0],
        machine.screws_mm[i][1],
        lead_mm,
        kFullSteps_per_rev,
        Microsteps(z));
  }
  text += "axes:\n";
  std::vector<std::string> steps, gaps;
  const std::string_view motors = machine.is_corexy ? "abz" : "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisText& axis = machine.axes[i];
    text += AxisYaml("xyz"[i], axis);
    // A bed on screws has no other drive of which a machine file states steps/mm.
    const bool is_own = !has_screws || machine.is_corexy || i == 2;
    if (is_own)
      steps.push_back(fmt::format("{}: {:.9g}", motors[i], axis.steps_per_mm));
    if (is_own && Known(axis.backlash_mm))
      gaps.push_back(fmt::format("{}: {:g}", motors[i], axis.backlash_mm));
  }
  return text + fmt::format("settings: {{steps_per_mm: {{{}}}{}}}\n",
                            fmt::join(steps, ", "),
                            gaps.empty() ? ""
                                         : fmt::format(", backlash_mm: {{{}}}",
                                                       fmt::join(gaps, ", ")));
}

}  // namespace caltwin
