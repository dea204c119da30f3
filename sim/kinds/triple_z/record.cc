#include "sim/kinds/triple_z/record.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/in_force.h"

namespace caltwin {

TripleZRecord::TripleZRecord(const Machine& machine, double sigma_mm)
    : machine_(machine) {
  header_.machine = machine.name;
  header_.instruments["probe"] = {.kind = "probe", .sigma_um = UmFromMm(sigma_mm)};
  header_.tip_radius_mm = machine.settings.tip_radius_mm;
  for (int i = 0; i < kNumScrews; ++i) {
    const ScrewDrawing& screw = TripleZOf(machine).screws[static_cast<std::size_t>(i)];
    header_.transmission[ScrewName(i)] = {
        .lead_mm = screw.lead_mm,
        .full_steps_per_mm = screw.full_steps_per_rev / screw.lead_mm};
  }
}

std::string TripleZRecord::IdOf(const ProbedPoint& touch) {
  const auto found =
      std::ranges::find_if(header_.settings, [&](const auto& id_and_settings) {
        const SettingsInForce& settings = id_and_settings.second;
        return settings.steps_per_mm.at("z") == touch.steps_per_mm &&
               settings.backlash_mm.at("z") == touch.backlash_mm;
      });
  if (found != header_.settings.end()) return found->first;
  const std::string id = fmt::format("s{}", header_.settings.size() + 1);
  header_.settings[id] = AsHeader(machine_.settings, *machine_.kind);
  header_.settings[id].steps_per_mm["z"] = touch.steps_per_mm;
  header_.settings[id].backlash_mm["z"] = touch.backlash_mm;
  return id;
}

void TripleZRecord::Add(const std::string& campaign,
                        std::span<const ProbedPoint> touches) {
  for (const ProbedPoint& touch : touches) {
    header_.campaigns[campaign].instrument = "probe";
    Row row{.row = static_cast<std::int64_t>(rows_.rows.size()) + 1,
            .campaign = campaign,
            .kind = RowKind::kTouch,
            .setup = "bed",
            .home = fmt::format("{}", touch.homing),
            .settings = IdOf(touch),
            .t_s = touch.at_s};
    row.cmd_mm = {touch.at_mm[0], touch.at_mm[1], 0};
    const ScrewCells screws = ScrewCellsOf(&row, machine_.kind->drive_map() != nullptr);
    for (std::size_t i = 0; i < screws.mm->size(); ++i) {
      (*screws.mm)[i] =
          TripleZOf(machine_).top_mm + touch.raised_mm[static_cast<Eigen::Index>(i)];
    }
    // The bed came up to a nozzle that stood.
    row.dir = {0, 0, -1};
    screws.dir->fill(1);
    row.feed_mm_s = touch.feed_mm_s;
    row.n = {0, 0, 1};
    row.feature = "bed.top";
    row.value_mm = touch.stopped_mm;
    rows_.rows.push_back(std::move(row));
  }
}

}  // namespace caltwin
