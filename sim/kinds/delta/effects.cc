#include "sim/kinds/delta/effects.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

/// Where an effect acts: on which tower or direction (-1: on all, or none).
struct DeltaTarget {
  int tower = -1;
  char along = 'x';
};

/// One parameter of one effect of a delta.
struct DeltaParameter {
  std::string_view cause{};
  std::string_view axes{};  ///< "" none, "t" tower, "xy" or "z" direction.
  std::string_view name{};
  Bounds own{};  ///< Where the catalogue has no such parameter.
  void (*act)(BuiltDelta*, const DeltaTarget&, double) = nullptr;
};

std::size_t At(const DeltaTarget& target) {
  return static_cast<std::size_t>(target.tower);
}

// Signs as CONTRACT and docs/signs.md have them.
constexpr std::array kParameters = {
    DeltaParameter{"endstop",
                   "t",
                   "error_mm",
                   {-20, 20},
                   [](BuiltDelta* d, const DeltaTarget& t, double v) {
                     d->build.model.endstop_mm[At(t)] += v;
                   }},
    DeltaParameter{"delta_radius",
                   "",
                   "error_mm",
                   {-20, 20},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     for (double& radius : d->build.model.radius_mm) radius += v;
                   }},
    DeltaParameter{"tower_angle",
                   "t",
                   "angle_deg",
                   {-10, 10},
                   [](BuiltDelta* d, const DeltaTarget& t, double v) {
                     StandRound(t.tower, RadFromDeg(v), &d->build);
                   }},
    DeltaParameter{"arm_length",
                   "",
                   "error_mm",
                   {-20, 20},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     for (double& arm : d->build.model.arm_mm) arm += v;
                   }},
    DeltaParameter{"effector_tilt",
                   "",
                   "tilt_x_mrad",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->build.tool_tilt_x_rad += RadFromMrad(v);
                   }},
    DeltaParameter{"effector_tilt",
                   "",
                   "tilt_y_mrad",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->build.tool_tilt_y_rad += RadFromMrad(v);
                   }},
    DeltaParameter{"bed_tilt",
                   "",
                   "slope_x_mrad",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->bed.slope_x += RadFromMrad(v);
                   }},
    DeltaParameter{"bed_tilt",
                   "",
                   "slope_y_mrad",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->bed.slope_y += RadFromMrad(v);
                   }},
    DeltaParameter{"bed_bowl",
                   "",
                   "height_um",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->bed.bowl_mm += MmFromUm(v);
                   }},
    DeltaParameter{"bed_cylinder",
                   "xy",
                   "height_um",
                   {},
                   [](BuiltDelta* d, const DeltaTarget& t, double v) {
                     (t.along == 'x' ? d->bed.cylinder_x_mm : d->bed.cylinder_y_mm) +=
                         MmFromUm(v);
                   }},
    DeltaParameter{"bed_twist",
                   "",
                   "height_um",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->bed.twist_mm += MmFromUm(v);
                   }},
    DeltaParameter{"trigger_scatter",
                   "",
                   "sd_um",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->scatter_mm = std::hypot(d->scatter_mm, MmFromUm(v));
                   }},
    DeltaParameter{"probe_offset",
                   "",
                   "dx_mm",
                   {-100, 100},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->tip.off_mm[0] += v;
                   }},
    DeltaParameter{"probe_offset",
                   "",
                   "dy_mm",
                   {-100, 100},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->tip.off_mm[1] += v;
                   }},
    DeltaParameter{"probe_offset",
                   "",
                   "dz_mm",
                   {-50, 50},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->tip.off_mm[2] += v;
                   }},
    DeltaParameter{"probe_pretravel",
                   "z",
                   "pretravel_mm",
                   {},
                   [](BuiltDelta* d, const DeltaTarget&, double v) {
                     d->tip.pretravel_mm = v;
                   }}};

// As the effect is bounded on every machine.
Bounds BoundsOf(const DeltaParameter& parameter) {
  return DeclaredBounds(parameter.cause, parameter.name).value_or(parameter.own);
}

std::optional<DeltaTarget> TargetNamed(std::string_view axes, std::string_view axis) {
  if (axes.empty()) return axis.empty() ? std::optional(DeltaTarget{}) : std::nullopt;
  if (axes == "z") {
    return axis == "z" ? std::optional(DeltaTarget{.along = 'z'}) : std::nullopt;
  }
  if (axes == "xy") {
    if (axis != "x" && axis != "y") return std::nullopt;
    return DeltaTarget{.along = axis[0]};
  }
  if (const auto tower = TowerNamed(axis)) return DeltaTarget{.tower = *tower};
  return std::nullopt;
}

std::string_view AxesInWords(std::string_view axes) {
  if (axes == "t") return ".a .b .c";
  if (axes == "xy") return ".x .y";
  if (axes == "z") return ".z";
  return "no axis";
}

std::vector<const DeltaParameter*> ParametersOf(std::string_view cause) {
  std::vector<const DeltaParameter*> found;
  for (const DeltaParameter& parameter : kParameters) {
    if (parameter.cause == cause) found.push_back(&parameter);
  }
  return found;
}

// `names`: what may be meant.
void ReadEffect(const std::string& name,
                const YamlValue& value,
                const std::vector<std::string>& names,
                std::vector<DeltaInjected>* effects) {
  const std::string cause = name.substr(0, name.find('.'));
  const std::string axis =
      name.size() > cause.size() ? name.substr(cause.size() + 1) : "";
  const auto parameters = ParametersOf(cause);
  if (parameters.empty()) {
    const std::string nearest = NearestWord(cause, names);
    value.Fail("is no effect of a delta",
               (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                   fmt::format("there are {}", fmt::join(names, ", ")));
    return;
  }
  if (!TargetNamed(parameters.front()->axes, axis)) {
    value.Fail(fmt::format("does not say where: '{}' stands with {}",
                           cause,
                           AxesInWords(parameters.front()->axes)));
    return;
  }
  YamlMap map = value.Map();
  for (const DeltaParameter* parameter : parameters) {
    if (const auto number = map.Optional(std::string(parameter->name))) {
      effects->push_back({.name = name,
                          .parameter = std::string(parameter->name),
                          .value = number->NumberOrDistribution(BoundsOf(*parameter)),
                          .place = number->place()});
    }
  }
  map.NoMoreKeys();
}

// Whether the catalogue has it, for deltas; what this list has is the twin's own.
bool IsOfCatalog(const std::string& cause) {
  const auto effect = FindEffect(cause);
  return ParametersOf(cause).empty() && effect &&
         !AxesOn(EffectAt(*effect), DeltaKind()).empty();
}

}  // namespace

std::vector<std::string> DeltaEffectNames() {
  std::vector<std::string> names;
  for (const DeltaParameter& parameter : kParameters) {
    if (names.empty() || names.back() != parameter.cause) {
      names.emplace_back(parameter.cause);
    }
  }
  for (const Effect* effect : AllEffects()) {
    if (IsOfCatalog(std::string(effect->name))) names.emplace_back(effect->name);
  }
  return names;
}

DeltaEffects ReadDeltaEffects(YamlMap map, const Machine& machine) {
  const std::vector<std::string> names = DeltaEffectNames();
  DeltaEffects read;
  std::vector<std::pair<std::string, YamlValue>> of_catalog;
  for (const auto& [name, value] : map.Entries()) {
    if (IsOfCatalog(name.substr(0, name.find('.')))) {
      of_catalog.emplace_back(name, value);
    } else {
      ReadEffect(name, value, names, &read.parts);
    }
  }
  read.effects = ReadEffects(of_catalog, machine);
  return read;
}

DrawnDelta DrawDelta(const DeltaEffects& effects,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample) {
  DrawnDelta drawn{.built = {.build = DeltaOf(machine).Build()}};
  BuiltDelta& built = drawn.built;
  built.bed.radius_mm = DeltaOf(machine).print_radius_mm;
  for (const DeltaInjected& effect : effects.parts) {
    Rng rng(seed, sample, effect.name + "." + effect.parameter);
    const double value = Draw(effect.value, &rng);
    const std::string cause = effect.name.substr(0, effect.name.find('.'));
    const std::string axis =
        effect.name.size() > cause.size() ? effect.name.substr(cause.size() + 1) : "";
    for (const DeltaParameter* parameter : ParametersOf(cause)) {
      if (parameter->name != effect.parameter) continue;
      parameter->act(&built, *TargetNamed(parameter->axes, axis), value);
    }
  }
  drawn.others = TurnBuild(DrawEffects(effects.effects, seed, sample), &built.build);
  return drawn;
}

DeltaEffects ReadDeltaTruthFile(const std::filesystem::path& file,
                                const Machine& machine) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  DeltaEffects truth;
  if (const auto effects = map.Optional("effects")) {
    truth = ReadDeltaEffects(effects->Map(), machine);
  }
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return truth;
}

}  // namespace caltwin
