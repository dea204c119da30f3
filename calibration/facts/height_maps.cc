#include "calibration/facts/height_maps.h"

#include <algorithm>
#include <cmath>

namespace caltwin {

std::vector<std::pair<std::string, HeightMap>> HeightMapsOf(const Rows& rows,
                                                            const Repeats& repeats) {
  std::vector<std::pair<std::string, HeightMap>> maps;
  for (const Row* row : rows) {
    const bool is_height = row->kind == RowKind::kTouch && row->n[2] > 0 &&
                           Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]) &&
                           !repeats.outliers.contains(row->row);
    if (!is_height) continue;
    auto own = std::ranges::find(
        maps, row->campaign, [](const auto& map) { return map.first; });
    if (own == maps.end()) own = maps.insert(own, {row->campaign, {}});
    own->second[{std::lround(100 * row->cmd_mm[0]), std::lround(100 * row->cmd_mm[1])}]
        .push_back(row);
  }
  return maps;
}

}  // namespace caltwin
