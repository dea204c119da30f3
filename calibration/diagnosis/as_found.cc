#include "calibration/diagnosis/as_found.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/injected.h"
#include "sim/effects/map_table.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// The effect in the list, added with its neutral values where it is not yet there.
Injected* Find(int effect,
               const std::string& axis,
               const Machine& machine,
               std::vector<Injected>* effects) {
  for (Injected& one : *effects) {
    if (one.effect == effect && one.axis == axis) return &one;
  }
  Injected fresh{.effect = effect, .axis = axis};
  const auto count = EffectAt(effect).parameters.size();
  for (std::size_t p = 0; p < count; ++p) {
    fresh.values.push_back(BuiltValue(machine, *effects, effect, axis, p));
  }
  effects->push_back(std::move(fresh));
  return &effects->back();
}

bool BuildScale(double scale_ppm,
                int drive,
                const Machine& machine,
                std::vector<Injected>* effects) {
  const auto k = static_cast<std::size_t>(drive);
  const AxisDrawing& drawing = machine.axes[k];
  double set = machine.settings.steps_per_mm[k];
  if (set <= 0) set = drawing.steps_per_mm();
  // The line counts from the drawing.
  const double more = FractionFromPpm(scale_ppm) - (set / drawing.steps_per_mm() - 1);
  const std::string name = DriveName(machine.kind->drive_map(), drive);
  double& steps_per_mm =
      Find(EffectIndex<StepsPerMm>(), name, machine, effects)->values[0];
  const double inverse = 1 / steps_per_mm + more / set;
  if (inverse <= 0) return false;
  steps_per_mm = 1 / inverse;
  return true;
}

bool BuildGap(double gap_mm,
              int drive,
              const Machine& machine,
              std::vector<Injected>* effects) {
  const auto k = static_cast<std::size_t>(drive);
  if (WeightKeepsGapShut(kAxes[k], machine.axes[k])) return false;
  const std::string name = DriveName(machine.kind->drive_map(), drive);
  const double built_mm =
      BuiltValue(machine, *effects, EffectIndex<Backlash>(), name, 0);
  if (built_mm + gap_mm < 0) return false;
  Find(EffectIndex<Backlash>(), name, machine, effects)->values[0] += gap_mm;
  return true;
}

bool BuildPretravel(double pretravel_mm,
                    Axis axis,
                    const Machine& machine,
                    std::vector<Injected>* effects) {
  if (pretravel_mm < ProbePretravel::kParameters[0].min) return false;
  std::erase_if(*effects, [&](const Injected& one) {
    return one.effect == EffectIndex<ProbePretravel>() &&
           one.axis.starts_with(Name(axis));
  });
  Find(EffectIndex<ProbePretravel>(), Name(axis), machine, effects)->values[0] =
      pretravel_mm;
  return true;
}

}  // namespace

std::optional<Injected> EffectOf(const Finding& finding) {
  if (finding.effect) {
    if (finding.effect->effect == EffectIndex<HomingScatter>()) return std::nullopt;
    return finding.effect;
  }
  if (!finding.map || finding.map->knots.empty()) return std::nullopt;
  const FreeMap& map = *finding.map;
  if (!std::ranges::all_of(map.covariates, IsCovariate)) return std::nullopt;
  const bool is_pitch = finding.cause == PitchMap::kDeclaration.name;
  return Injected{
      .effect = is_pitch ? EffectIndex<PitchMap>() : EffectIndex<UnknownMap>(),
      .axis = is_pitch ? map.channel : MapAxis(map.channel, map.covariates),
      .values = FlatMap(map.values_um, map.knots)};
}

bool BuildIn(const BaselineLine& line,
             const Machine& machine,
             std::vector<Injected>* effects) {
  if (DiagnosedAs(machine).turns_build()) return false;
  const std::string_view name(line.name);
  const std::string_view kind = name.substr(0, name.find('.'));
  const std::string_view word = name.substr(std::min(name.size(), kind.size() + 1));
  if (kind == "bed_plane" && word.starts_with("slope_")) {
    Injected* tilt = Find(EffectIndex<BedTilt>(), "", machine, effects);
    tilt->values[word == "slope_x" ? 0 : 1] += line.value;
    return true;
  }
  if (kind == "probe_pretravel") {
    const std::optional<Axis> axis = AxisNamed(word);
    return axis && BuildPretravel(line.value, *axis, machine, effects);
  }
  if (kind != "scale" && kind != "backlash") return false;
  // A letter a drive: "ab" are two alike.
  bool is_built = !word.empty();
  for (std::size_t i = 0; i < word.size(); ++i) {
    const auto drive = DriveIndex(machine.kind->drive_map(), word.substr(i, 1));
    is_built &=
        drive && (kind == "scale" ? BuildScale(line.value, *drive, machine, effects)
                                  : BuildGap(line.value, *drive, machine, effects));
  }
  return is_built;
}

AsFound AsFoundBy(const Observed& observed,
                  const std::vector<BaselineLine>& baseline,
                  const std::vector<Finding>& findings) {
  AsFound as_found{.effects = observed.effects()};
  for (const BaselineLine& line : baseline) {
    if (BuildIn(line, observed.machine(), &as_found.effects)) {
      as_found.built.insert(line.name);
    }
  }
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (const auto effect = EffectOf(findings[i])) {
      as_found.effects.push_back(*effect);
    } else {
      as_found.not_built.push_back(i);
    }
  }
  return as_found;
}

}  // namespace caltwin
