// Whether rows are commanded where the machine can go.

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
bool CanStandAt(const Machine* machine, int axis, double position_mm) {
  constexpr double kFarthest_mm = 4000;  // No bench is longer.
  if (machine == nullptr) return std::abs(position_mm) <= kFarthest_mm;
  return DiagnosedAs(*machine).CanStandAt(*machine, axis, position_mm);
}

bool DiagnosedKind::CanStandAt(const Machine& machine,
                               int axis,
                               double position_mm) const {
  const AxisDrawing& travel = machine.axes[static_cast<std::size_t>(axis)];
  const double beyond_mm = kBeyondTravel * (travel.max_mm - travel.min_mm);
  return position_mm >= travel.min_mm - beyond_mm &&
         position_mm <= travel.max_mm + beyond_mm;
}

void DoubtTravel(const RowTable& table,
                 const Machine& machine,
                 std::vector<Doubt>* doubts) {
  DiagnosedAs(machine).DoubtTravel(table, machine, doubts);
}

void DiagnosedKind::DoubtTravel(const RowTable& table,
                                const Machine& machine,
                                std::vector<Doubt>* doubts) const {
  for (const Axis axis : kAxes) {
    const int index = Index(axis);
    const double min_mm = machine.axes[index].min_mm;
    const double max_mm = machine.axes[index].max_mm;
    Doubt doubt{.kind = "outside_travel", .refuse = true};
    for (const Row& row : table.rows) {
      const double position_mm = row.cmd_mm[index];
      if (Known(position_mm) && !CanStandAt(machine, index, position_mm)) {
        doubt.rows.push_back(row.row);
      }
    }
    if (doubt.rows.empty()) continue;
    doubt.message = fmt::format(
        "{} rows are commanded beyond the travel of {} ({:g} .. {:g} mm), "
        "the first is row {}",
        doubt.rows.size(),
        Name(axis),
        min_mm,
        max_mm,
        doubt.rows.front());
    doubt.hint = "the wrong machine file, or another unit or zero of the positions";
    doubts->push_back(std::move(doubt));
  }
}

void DoubtReachInInches(const RowTable& table,
                        const Machine& machine,
                        std::vector<Doubt>* doubts) {
  constexpr double kInch_mm = MmFromInch(1.0);
  constexpr double kMostOfTravel = 0.6;
  constexpr std::size_t kFewest = 5;
  if (!machine.kind->moves_along_axes()) return;
  for (const Axis axis : kAxes) {
    const int index = Index(axis);
    const auto at = static_cast<std::size_t>(index);
    std::set<double> positions_mm;
    for (const Row& row : table.rows) {
      const bool is_along =
          row.kind == RowKind::kPosition && std::abs(row.n[at]) > 0.99;
      if (is_along && Known(row.cmd_mm[at])) positions_mm.insert(row.cmd_mm[at]);
    }
    if (positions_mm.size() < kFewest) continue;
    const double low_mm = *positions_mm.begin(), high_mm = *positions_mm.rbegin();
    const double travel_mm = machine.axis(axis).travel_mm();
    const bool would_fill = kInch_mm * (high_mm - low_mm) > kMostOfTravel * travel_mm &&
                            CanStandAt(&machine, index, kInch_mm * low_mm) &&
                            CanStandAt(&machine, index, kInch_mm * high_mm);
    if (!would_fill) continue;
    doubts->push_back(
        {.kind = "position_unit",
         .message =
             fmt::format("every position along {} lies within {:.4g} .. {:.4g} mm "
                         "of a travel of {:g} mm",
                         Name(axis),
                         low_mm,
                         high_mm,
                         travel_mm),
         .hint = fmt::format("in inches that would be {:.4g} .. {:.4g} mm, most of the "
                             "travel; if it is, every figure per length is wrong by "
                             "25.4",
                             kInch_mm * low_mm,
                             kInch_mm * high_mm)});
  }
}

void DoubtDrives(const DataHeader& header,
                 const Machine& machine,
                 std::vector<Doubt>* doubts) {
  constexpr double kFarthest = 0.05;  // What wrong steps/mm may be off by.
  for (const auto& [id, settings] : header.settings) {
    for (const Axis axis : kAxes) {
      const auto set = settings.steps_per_mm.find(Name(axis));
      if (!machine.kind->moves_along_axes() || set == settings.steps_per_mm.end() ||
          set->second <= 0) {
        continue;
      }
      const double drawn = machine.axis(axis).steps_per_mm();
      const double moved = set->second / drawn;
      if (std::abs(moved - 1) < kFarthest) continue;
      doubts->push_back(
          {.kind = "other_drive",
           .message = fmt::format(
               "the settings '{}' were {:g} steps/mm along {}, the machine file's "
               "drive "
               "takes {:g}: by it the axis moves {:.3g} mm for every mm commanded",
               id,
               set->second,
               Name(axis),
               drawn,
               moved),
           .hint = "another machine's file, or its lead, pulley, full steps or "
                   "microsteps are not those of the machine measured"});
    }
  }
}

}  // namespace caltwin
