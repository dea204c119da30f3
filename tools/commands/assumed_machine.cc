#include "tools/commands/assumed_machine.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr double kLeastTravel_mm = 1;

// The commanded positions of an axis; empty (least above largest) where rows know none.
std::pair<double, double> Reach_mm(const RowTable& table, Axis axis) {
  double least = std::numeric_limits<double>::infinity(), largest = -least;
  for (const Row& row : table.rows) {
    const double at_mm = row.cmd_mm[Index(axis)];
    if (!Known(at_mm)) continue;
    least = std::min(least, at_mm);
    largest = std::max(largest, at_mm);
  }
  return {least, largest};
}

}  // namespace

Machine AssumedMachine(const RowTable& table, std::vector<std::string>* notes) {
  Machine machine;
  machine.name = "assumed";
  std::vector<std::string> travels;
  double lead_mm = 0;
  for (const Axis axis : kAxes) {
    AxisDrawing& drawing = machine.axes[Index(axis)];
    machine.settings.steps_per_mm[Index(axis)] = drawing.steps_per_mm();
    const auto [least_mm, largest_mm] = Reach_mm(table, axis);
    if (least_mm > largest_mm) continue;
    drawing.min_mm = least_mm;
    drawing.max_mm = std::max(largest_mm, least_mm + kLeastTravel_mm);
    travels.push_back(
        fmt::format("{} {:g} to {:g}", Name(axis), drawing.min_mm, drawing.max_mm));
    lead_mm = drawing.lead_mm;
  }
  if (!travels.empty()) {
    notes->push_back(
        fmt::format("no machine is named (--machine): taken to travel as far as the "
                    "rows go ({} mm), "
                    "with leads of {:g} mm where the header does not say",
                    fmt::join(travels, ", "),
                    lead_mm));
  }
  return machine;
}

namespace {

// The steps per mm that all settings agree on.
std::optional<double> StepsStated(const DataHeader& header, Axis axis) {
  std::set<double> stated;
  for (const auto& [id, settings] : header.settings) {
    const auto found = settings.steps_per_mm.find(Name(axis));
    if (found != settings.steps_per_mm.end()) stated.insert(found->second);
  }
  if (stated.size() != 1) return std::nullopt;
  return *stated.begin();
}

}  // namespace

Machine WithSettingsOf(Machine machine, const DataHeader& header) {
  for (const Axis axis : kAxes) {
    const auto stated = StepsStated(header, axis);
    if (stated) machine.settings.steps_per_mm[Index(axis)] = *stated;
  }
  return machine;
}

Machine WithStepsAsSet(Machine machine, const DataHeader& header) {
  for (const Axis axis : kAxes) {
    const auto stated = StepsStated(header, axis);
    if (!stated) continue;
    AxisDrawing& drawing = machine.axes[Index(axis)];
    drawing.microsteps = *stated * drawing.lead_mm / drawing.full_steps_per_rev;
    machine.settings.steps_per_mm[Index(axis)] = drawing.steps_per_mm();
  }
  return machine;
}

Machine WithTransmission(Machine machine, const DataHeader& header) {
  for (const Axis axis : kAxes) {
    const auto stated = header.transmission.find(Name(axis));
    if (stated == header.transmission.end()) continue;
    const auto at = Index(axis);
    AxisDrawing& drawing = machine.axes[at];
    const Transmission& is = stated->second;
    const bool was_as_drawn =
        machine.settings.steps_per_mm[at] == drawing.steps_per_mm();
    if (is.lead_mm || is.pulley_mm_per_rev) {
      drawing.is_belt = !is.lead_mm.has_value();
      drawing.lead_mm = is.lead_mm ? *is.lead_mm : *is.pulley_mm_per_rev;
    }
    if (is.full_steps_per_mm) {
      drawing.full_steps_per_rev = *is.full_steps_per_mm * drawing.lead_mm;
    }
    if (was_as_drawn) machine.settings.steps_per_mm[at] = drawing.steps_per_mm();
  }
  return machine;
}

}  // namespace caltwin
