#include "calibration/facts/cells.h"

#include <algorithm>
#include <cmath>

namespace caltwin {
namespace {

constexpr double kAlong = 0.999;

void Add(std::string* key, double value, double step) {
  *key += '|';
  *key += Known(value) ? std::to_string(std::llround(value / step)) : "?";
}

}  // namespace

Cells CellsOf(const std::vector<const Row*>& rows, unsigned freedom) {
  Cells cells;
  for (const Row* row : rows) {
    std::string key = std::to_string(static_cast<int>(row->kind)) + "|" + row->feature +
                      "|" + row->settings;
    if ((freedom & kAnyCampaign) == 0) key += "|" + row->campaign + "|" + row->setup;
    if ((freedom & kAnyHome) == 0) key += "|" + row->home;
    for (std::size_t k = 0; k < 3; ++k) {
      Add(&key, row->cmd_mm[k], 1e-3);
      Add(&key, row->n[k], 1e-3);
      Add(&key, row->probe_off_mm[k], 1e-3);
      Add(&key, row->motor_mm[k], 1e-3);
      Add(&key, row->screw_mm[k], 1e-3);
      if ((freedom & kAnySense) == 0) Add(&key, row->dir[k], 1);
    }
    if ((freedom & kAnyFeed) == 0) Add(&key, row->feed_mm_s, 1e-3);
    Add(&key, row->load_n, 1e-2);
    Add(&key, row->probe_angle_deg, 1e-2);
    Add(&key, row->artefact_turn_deg, 1e-2);
    cells[key].push_back(row);
  }
  return cells;
}

std::vector<const Row*> RowsInOrder(const RowTable& table) {
  std::vector<const Row*> rows;
  for (const Row& row : table.rows) rows.push_back(&row);
  std::ranges::stable_sort(rows, {}, &Row::row);
  return rows;
}

int AxisAlong(const Row& row) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(row.n[static_cast<std::size_t>(axis)]) > kAlong) return axis;
  }
  return -1;
}

}  // namespace caltwin
