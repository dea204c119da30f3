#include "calibration/diagnosis/kinds/delta_lines.h"

#include <cstddef>

#include <fmt/format.h>

#include "sim/effects/catalog.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

std::vector<KnobTurn<double>> KnobsOfLine(std::string_view name,
                                          double value,
                                          const DeltaDrawing& drawing) {
  if (name == "bed_plane.slope_x") return {{kBedKnob, value}};
  if (name == "bed_plane.slope_y") return {{kBedKnob + 1, value}};
  if (name == "scale") {
    return {{kBeltKnob, value}, {kBeltKnob + 1, value}, {kBeltKnob + 2, value}};
  }
  const auto knob = DeltaKnobNamed(name);
  if (!knob) return {};
  if (IsAngleKnob(*knob) && drawing.states_effector) {
    return {{*knob, value / TwistPerAngle(drawing.model, drawing.effector_radius_mm)}};
  }
  if (*knob >= kRadiusKnob) return {{*knob, value}};
  return {{*knob, value}, {kEndstopKnob + 2, -value}};
}

DeltaBuild<double> BelievedBuild(const Observed& observed) {
  DeltaBuild<double> build = DeltaOf(observed.machine()).Build();
  DeltaBed<double> bed;
  for (int knob = 0; knob < kNumDeltaKnobs; ++knob) {
    const auto k = static_cast<std::size_t>(knob);
    TurnKnob(knob, observed.turns()[k] * kDeltaKnobs[k].per_unit, &build, &bed);
  }
  TurnBuild(observed.effects(), &build);
  return build;
}

namespace {

// Of the first touch; the places of others are their own.
std::string TouchedSetup(const Observed& observed) {
  for (const Row& row : observed.table().rows) {
    if (row.kind != RowKind::kTouch) continue;
    return row.setup.empty() ? std::string(ArtefactOf(row)) : row.setup;
  }
  return "";
}

}  // namespace

FoundDelta DeltaWithBaseline(const Observed& observed,
                             const std::vector<BaselineLine>& lines) {
  FoundDelta found{.build = DeltaOf(observed.machine()).Build()};
  const std::string bed_line = fmt::format("placement.{}.z", TouchedSetup(observed));
  for (const BaselineLine& line : lines) {
    for (const auto& [knob, by] :
         KnobsOfLine(line.name, line.value, DeltaOf(observed.machine()))) {
      const double inside = by * kDeltaKnobs[static_cast<std::size_t>(knob)].per_unit;
      TurnKnob(knob, inside, &found.build, &found.bed);
    }
    if (line.name == bed_line) found.bed.height_mm = line.value;
  }
  return found;
}

}  // namespace caltwin
