#include "tools/commands/kinds/simulated_station.h"

#include <array>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

/// A station's number that one parameter of a cause is, in um of its unit.
struct StationWord {
  std::string_view cause;
  std::string_view axis;
  std::string_view parameter;
  double ZStation::*member;
  double sign = 1;
};
constexpr std::array kWords = {
    StationWord{"switch_offset", "", "off_um", &ZStation::trigger_mm},
    StationWord{"ooze", "", "thickness_um", &ZStation::ooze_mm},
    StationWord{
        "nozzle_temperature", "", "growth_um_per_k", &ZStation::nozzle_mm_per_k},
    StationWord{
        "frame_temperature", "frame", "growth_um_per_k", &ZStation::frame_mm_per_k},
    StationWord{
        "frame_temperature", "bed", "growth_um_per_k", &ZStation::surface_mm_per_k},
    StationWord{
        "probe_temperature", "", "drift_um_per_k", &ZStation::trigger_mm_per_k, -1}};

[[noreturn]] void RefuseSimulatedStation(const TwinOptions& named,
                                         const std::string& what) {
  throw InputError({.file = named.truth},
                   what + " needs times or a log, which calibrating a twin has not",
                   "`caltwin simulate --truth` has them; `station:` of a scenario has "
                   "an operator's acts");
}

void Build(const Injected& injected, const TwinOptions& named, ZStation* station) {
  const Effect& effect = EffectAt(injected.effect);
  bool is_built = false;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const std::string_view parameter = effect.parameters[i].name;
    const double value = injected.values[i];
    if (parameter == "flows_c") station->ooze_flows_c = value;
    if (parameter == "lag_s" && value != 0) {
      RefuseSimulatedStation(named, fmt::format("a lag of '{}'", effect.name));
    }
    for (const StationWord& word : kWords) {
      const bool is_it = word.cause == effect.name && word.axis == injected.axis &&
                         word.parameter == parameter;
      if (!is_it) continue;
      station->*word.member += word.sign * MmFromUm(value);
      is_built = true;
    }
    if (effect.name == "trigger_scatter" && parameter == "sd_um") {
      station->endstop_scatter_mm = station->probe_scatter_mm = MmFromUm(value);
      is_built = true;
    }
  }
  if (!is_built) RefuseSimulatedStation(named, fmt::format("'{}'", effect.name));
}

ZStation BuiltAs(const TwinConfig& config, const TwinOptions& named) {
  const ZStationDrawing& drawn = ZStationOf(config.machine);
  ZStation station{.switch_mm = drawn.switch_mm,
                   .body_mm = drawn.body_mm,
                   .trigger_mm = drawn.trigger_mm,
                   // What grows and scatters, the truth says.
                   .endstop_scatter_mm = 0,
                   .probe_scatter_mm = 0,
                   .nozzle_mm_per_k = 0,
                   .bed_mm_per_k = 0,
                   .frame_mm_per_k = 0};
  for (const Injected& injected : config.effects) Build(injected, named, &station);
  return station;
}

}  // namespace

ZStation BuiltStation(const TwinOptions& named) {
  return BuiltAs(MakeTwinConfig(named, /*only_measures=*/true), named);
}

SimulatedStation::Parts SimulatedStation::PartsOf(const TwinOptions& named) {
  const TwinConfig config = MakeTwinConfig(named, /*only_measures=*/true);
  const ZStationDrawing& drawn = ZStationOf(config.machine);
  return {.station = BuiltAs(config, named),
          .config = {.position_endstop_mm = drawn.switch_mm,
                     .switch_offset_mm = drawn.trigger_mm,
                     .samples = 3,
                     .before_switch_gcode = "ATTACH_PROBE",
                     .end_gcode = "DETACH_PROBE",
                     .middle_mm = drawn.bed_at_mm}};
}

SimulatedStation::SimulatedStation(const TwinOptions& named)
    : SimulatedStation(PartsOf(named), named) {}

SimulatedStation::SimulatedStation(const Parts& parts, const TwinOptions& named)
    : twin_(parts.station,
            named.fidelity == "physics",
            named.seed,
            /*sample=*/0,
            parts.config.middle_mm),
      klipper_(parts.config, &twin_) {}

}  // namespace caltwin
