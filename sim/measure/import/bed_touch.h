#pragma once

#include <string>

#include "sim/measure/row.h"

namespace caltwin {

/// A touch of the bed from above, as printers report it: nominal height 0, normal + z,
/// approached downwards; the value is the height reported.
inline Row BedTouchRow(std::string campaign,
                       double x_mm,
                       double y_mm,
                       double height_mm,
                       const Place& place) {
  Row row{.campaign = std::move(campaign),
          .kind = RowKind::kTouch,
          .setup = "bed",
          .place = place};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.dir[2] = -1;
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = height_mm;
  return row;
}

}  // namespace caltwin
