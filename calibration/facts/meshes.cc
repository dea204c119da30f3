#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/height_maps.h"
#include "calibration/facts/surface.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

// Heights of the second less those of the first, where both have the place.
std::vector<double> ApartOf(const HeightMap& one, const HeightMap& other) {
  std::vector<double> apart_mm;
  for (const auto& [place, readings] : one) {
    const auto same = other.find(place);
    if (same == other.end()) continue;
    apart_mm.push_back(same->second.front()->value_mm - readings.front()->value_mm);
  }
  return apart_mm;
}

}  // namespace

void FactsOfMeshes(const Rows& rows, Repeats* repeats, Facts* facts) {
  constexpr std::size_t kFewest = 9;
  const auto meshes = HeightMapsOf(rows, *repeats);
  if (meshes.size() < 2 || Known(repeats->noise.sd_mm)) return;
  double squares_mm2 = 0, dof = 0, least_mm = 0, most_mm = 0;
  int num = 1;
  for (std::size_t i = 1; i < meshes.size(); ++i) {
    const std::vector<double> apart_mm =
        ApartOf(meshes.front().second, meshes[i].second);
    if (apart_mm.size() < kFewest) continue;
    const Average apart = AverageOf(apart_mm);
    squares_mm2 += apart.sd * apart.sd * (apart.num - 1) / 2;
    dof += apart.num - 1;
    least_mm = std::min(least_mm, apart.mean);
    most_mm = std::max(most_mm, apart.mean);
    ++num;
  }
  if (num < 2) return;
  const double sd_mm = std::sqrt(squares_mm2 / dof);
  repeats->noise = {.sd_mm = sd_mm, .dof = dof};
  facts->all.push_back(
      {.id = "repeatability",
       .axis = "z",
       .word = "meshes",
       .figures = {{"sd_um", UmFromMm(sd_mm), UmFromMm(sd_mm) / std::sqrt(2 * dof)},
                   {"apart_um", UmFromMm(most_mm - least_mm)}},
       .sentence = fmt::format(
           "{} meshes of the same places repeat to {} um a touch (standard deviation, "
           "{:.0f} degrees of freedom), once their heights are taken out, which are up "
           "to {} um apart",
           num,
           TwoDigits(UmFromMm(sd_mm)),
           dof,
           TwoDigits(UmFromMm(most_mm - least_mm)))});
}

}  // namespace caltwin
