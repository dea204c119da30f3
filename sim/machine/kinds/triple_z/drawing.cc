#include "sim/machine/kinds/triple_z/drawing.h"

#include <algorithm>
#include <cmath>

#include "sim/machine/screw_levelling.h"

namespace caltwin {
namespace {

void ReadScrew(YamlMap map, ScrewDrawing* screw) {
  if (const auto at = map.Optional("at_mm")) {
    const auto numbers = at->Numbers(2, {-1e4, 1e4});
    if (numbers.size() == 2) screw->at_mm = {numbers[0], numbers[1]};
  }
  screw->lead_mm = map.NumberOr("lead_mm", screw->lead_mm, {1e-3, 1e3});
  screw->full_steps_per_rev =
      map.NumberOr("full_steps_per_rev", screw->full_steps_per_rev, {1, 1e6});
  screw->microsteps = map.NumberOr("microsteps", screw->microsteps, {1, 4096});
  map.NoMoreKeys();
}

}  // namespace

std::string ScrewName(int screw) {
  return "z" + std::to_string(screw + 1);
}

std::optional<int> ScrewNamed(std::string_view name) {
  for (int i = 0; i < kNumScrews; ++i) {
    if (name == ScrewName(i)) return i;
  }
  return std::nullopt;
}

double TriangleShape(const Pivots<double>& pivots_mm) {
  const Eigen::Vector2d a = pivots_mm[1] - pivots_mm[0];
  const Eigen::Vector2d b = pivots_mm[2] - pivots_mm[0];
  const double longest_mm = std::max({a.norm(), b.norm(), (b - a).norm()});
  if (longest_mm == 0) return 0;
  return std::abs(a[0] * b[1] - a[1] * b[0]) / (longest_mm * longest_mm);
}

TripleZDrawing ReadTripleZDrawing(YamlMap* map) {
  TripleZDrawing drawing;
  const auto screws = map->Optional("screws");
  if (!screws) return drawing;
  YamlMap by_name = screws->Map();
  for (int i = 0; i < kNumScrews; ++i) {
    const auto screw = by_name.Optional(ScrewName(i));
    if (screw) ReadScrew(screw->Map(), &drawing.screws[static_cast<std::size_t>(i)]);
  }
  by_name.NoMoreKeys();
  if (TriangleShape(drawing.pivots_mm()) < kFlattestTriangle) {
    screws->Fail("stand nearly in one line", "three screws span a triangle");
  }
  return drawing;
}

}  // namespace caltwin
