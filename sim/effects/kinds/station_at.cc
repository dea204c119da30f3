#include "sim/effects/kinds/station_at.h"

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {

void AddStation(const Row& row, const Machine& machine, At* at) {
  if (machine.Own<ZStationDrawing>() == nullptr) return;
  at->station = ZReadingOf(row.feature);
  const bool is_gauge = row.kind == RowKind::kPosition;
  if (!at->station || (*at->station == ZReading::kGapUnderNozzle) != is_gauge) {
    throw InputError(
        row.place,
        fmt::format("row {}: feature '{}' of a {} is none of a printer's station",
                    row.row,
                    row.feature,
                    row.kind == RowKind::kTouch ? "touch" : "gauge's reading"),
        "touches: switch.nozzle, switch.body, bed.probe; a gauge: bed.gap");
  }
  at->on_table = *at->station == ZReading::kProbeOnBed;
  at->is_wiped = row.nozzle_wiped == 1;
}

}  // namespace caltwin
