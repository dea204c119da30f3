#include "calibration/diagnosis/screw_table.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr int kFewestPoints = 21;
constexpr double kPointsAPeriod = 8;

}  // namespace

std::string ScrewTableSuffix(Axis axis) {
  return fmt::format(".{}.comp", Name(axis));
}

int ScrewTablePoints(const Machine& machine,
                     Axis axis,
                     const std::vector<Injected>& effects) {
  int points = kFewestPoints;
  for (const Injected& effect : effects) {
    const auto parameters = EffectAt(effect.effect).parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].name != "period_mm") continue;
      const double turns = machine.axis(axis).travel_mm() / effect.values[i];
      points = std::max(points, static_cast<int>(kPointsAPeriod * turns) + 1);
    }
  }
  return points <= kMostScrewTablePoints ? points : 0;
}

std::string ScrewTableText(const Machine& machine,
                           Axis axis,
                           const std::vector<Injected>& effects,
                           double gap_mm) {
  const AxisDrawing& drawing = machine.axis(axis);
  const int points = ScrewTablePoints(machine, axis, effects);
  std::string table;
  for (int k = 0; k < points; ++k) {
    const double q_mm = drawing.min_mm + drawing.travel_mm() * k / (points - 1);
    std::array<double, 2> actual_mm{};
    for (int sense = 0; sense < 2; ++sense) {
      At at{.kind = RowKind::kPosition};
      at.q_mm[Index(axis)] = q_mm;
      at.dir[Index(axis)] = sense == 0 ? 1 : -1;
      const auto errors = ErrorsAt<double>(machine, at, effects);
      actual_mm[static_cast<std::size_t>(sense)] =
          q_mm + errors.motion_mm[Index(axis)] - at.dir[Index(axis)] * gap_mm / 2;
    }
    table += fmt::format("{:.4f} {:.5f} {:.5f}\n", q_mm, actual_mm[0], actual_mm[1]);
  }
  return table;
}

}  // namespace caltwin
