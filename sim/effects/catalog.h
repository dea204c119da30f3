#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/effects/angular.h"
#include "sim/effects/axis_twist.h"
#include "sim/effects/backlash.h"
#include "sim/effects/backlash_worn.h"
#include "sim/effects/bed_bowl.h"
#include "sim/effects/bed_cylinder.h"
#include "sim/effects/bed_tilt.h"
#include "sim/effects/bed_twist.h"
#include "sim/effects/belt_pitch.h"
#include "sim/effects/block_rotated.h"
#include "sim/effects/block_size.h"
#include "sim/effects/carriage_backlash.h"
#include "sim/effects/cyclic_lead.h"
#include "sim/effects/effect.h"
#include "sim/effects/effector_tilt.h"
#include "sim/effects/frame_growth.h"
#include "sim/effects/frame_temperature.h"
#include "sim/effects/gantry_sag.h"
#include "sim/effects/homing_scatter.h"
#include "sim/effects/knob_turns.h"
#include "sim/effects/microstep.h"
#include "sim/effects/missed_steps.h"
#include "sim/effects/motors_swapped.h"
#include "sim/effects/nozzle_temperature.h"
#include "sim/effects/ooze.h"
#include "sim/effects/overconstrained_bed.h"
#include "sim/effects/pitch_map.h"
#include "sim/effects/pitch_progressive.h"
#include "sim/effects/pivot_position.h"
#include "sim/effects/probe_lobing.h"
#include "sim/effects/probe_pretravel.h"
#include "sim/effects/probe_temperature.h"
#include "sim/effects/pulley_eccentric.h"
#include "sim/effects/racking.h"
#include "sim/effects/random_walk.h"
#include "sim/effects/reversal_spike.h"
#include "sim/effects/rod_mismatch.h"
#include "sim/effects/screw_backlash.h"
#include "sim/effects/screw_cyclic.h"
#include "sim/effects/screw_pitch.h"
#include "sim/effects/servo_lag.h"
#include "sim/effects/servo_mismatch.h"
#include "sim/effects/squareness.h"
#include "sim/effects/station_change.h"
#include "sim/effects/steps_per_mm.h"
#include "sim/effects/straightness.h"
#include "sim/effects/stylus_anisotropy.h"
#include "sim/effects/switch_offset.h"
#include "sim/effects/thermal_screw.h"
#include "sim/effects/tip_runout.h"
#include "sim/effects/tip_size.h"
#include "sim/effects/tower_lean.h"
#include "sim/effects/tower_radius.h"
#include "sim/effects/tower_twist.h"
#include "sim/effects/trigger_latency.h"
#include "sim/effects/trigger_scatter.h"
#include "sim/effects/unknown_map.h"
#include "sim/effects/windup_load.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// Every effect there is, in the order reports list them; a new one is one line here
/// and one in sim/effects/acts/catalog.cc. The index in this list is `Valued::effect`.
using EffectList = std::tuple<StepsPerMm,
                              Backlash,
                              WindupLoad,
                              CyclicLead,
                              PulleyEccentric,
                              Microstep,
                              PitchProgressive,
                              PitchMap,
                              BacklashWorn,
                              ReversalSpike,
                              ThermalScrew,
                              MissedSteps,
                              HomingScatter,
                              Squareness,
                              Straightness,
                              Angular,
                              GantrySag,
                              AxisTwist,
                              Racking,
                              BeltPitch,
                              CarriageBacklash,
                              RodMismatch,
                              TowerLean,
                              TowerTwist,
                              TowerRadius,
                              EffectorTilt,
                              ScrewPitch,
                              ScrewCyclic,
                              ScrewBacklash,
                              PivotPosition,
                              MotorsSwapped,
                              OverconstrainedBed,
                              ServoMismatch,
                              ServoLag,
                              FrameGrowth,
                              FrameTemperature,
                              RandomWalk,
                              ProbePretravel,
                              ProbeTemperature,
                              ProbeLobing,
                              StylusAnisotropy,
                              TipRunout,
                              TipSize,
                              TriggerLatency,
                              TriggerScatter,
                              NozzleTemperature,
                              Ooze,
                              SwitchOffset,
                              StationChange,
                              BedTilt,
                              BedBowl,
                              BedCylinder,
                              BedTwist,
                              BlockSize,
                              BlockRotated,
                              UnknownMap>;
inline constexpr std::size_t kNumEffects = std::tuple_size_v<EffectList>;

/// The declarations, in the list's order.
std::span<const Effect* const> AllEffects();
const Effect& EffectAt(int index);
std::optional<int> FindEffect(std::string_view name);

/// The index of an effect known when compiling: EffectIndex<Backlash>().
template <typename E, std::size_t kIndex = 0>
constexpr int EffectIndex() {
  if constexpr (std::is_same_v<E, std::tuple_element_t<kIndex, EffectList>>) {
    return static_cast<int>(kIndex);
  } else {
    return EffectIndex<E, kIndex + 1>();
  }
}

/// Adds what the effect of that index contributes.
template <typename T>
void AddErrors(int effect, const Asked<T>& asked, Errors<T>* errors) {
  using Form = void (*)(const Asked<T>&, Errors<T>*);
  static constexpr auto kForms =
      []<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
        return std::array<Form, kNumEffects>{
            &std::tuple_element_t<kIndex, EffectList>::template Add<T>...};
      }(std::make_index_sequence<kNumEffects>{});
  kForms[static_cast<std::size_t>(effect)](asked, errors);
}
/// Compiled once, in catalog.cc; other scalars where they are used.
extern template void AddErrors<double>(int, const Asked<double>&, Errors<double>*);

/// What may stand after the dot of the effect's name on such a machine; empty: it does
/// not have the effect.
std::span<const std::string_view> AxesOn(const Effect& effect, const MachineKind* kind);

/// Where an effect that diagnosis may find shows on such a machine.
Shown ShownOn(const Effect& effect, std::string_view axis, const MachineKind* kind);

/// Whether files may write this after the dot of the effect's name.
bool HasAxis(const Effect& effect, std::string_view axis, const MachineKind* kind);

/// What an effect turns of a delta's build; none where it does not act there.
std::vector<KnobTurn<double>> TurnsOf(const Injected& effect);

/// Turns a delta's build by all effects that act there; returns the others.
std::vector<Injected> TurnBuild(std::span<const Injected> effects,
                                DeltaBuild<double>* build);

/// How far a parameter of an effect may go, in its declared unit: the same wherever the
/// effect stands, also where a kind of machine builds it in as a part of its own.
/// nullopt: no effect of that name has it.
std::optional<Bounds> DeclaredBounds(std::string_view effect,
                                     std::string_view parameter);

/// The declared word for an axis as a file writes it: an alias becomes axes[0].
std::string AxisOf(const Effect& effect, std::string_view written);

}  // namespace caltwin
