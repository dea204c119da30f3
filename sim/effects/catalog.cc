#include "sim/effects/catalog.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "sim/base/require.h"
#include "sim/effects/drive.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

template <std::size_t... kIndex>
constexpr std::array<const Effect*, kNumEffects> Declarations(
    std::index_sequence<kIndex...>) {
  return {&std::tuple_element_t<kIndex, EffectList>::kDeclaration...};
}

constexpr auto kDeclarations = Declarations(std::make_index_sequence<kNumEffects>{});

}  // namespace

template void AddErrors<double>(int, const Asked<double>&, Errors<double>*);

std::span<const Effect* const> AllEffects() {
  return kDeclarations;
}

const Effect& EffectAt(int index) {
  Require(index >= 0 && index < static_cast<int>(kNumEffects), "no such effect");
  return *kDeclarations[static_cast<std::size_t>(index)];
}

std::optional<int> FindEffect(std::string_view name) {
  for (std::size_t i = 0; i < kNumEffects; ++i) {
    if (kDeclarations[i]->name == name) return static_cast<int>(i);
  }
  return std::nullopt;
}

std::span<const std::string_view> AxesOn(const Effect& effect,
                                         const MachineKind* kind) {
  const auto own = kind->effects();
  if (own.empty() && kind->has_other_effects()) return effect.axes;
  const auto found = std::ranges::find(own, effect.name, &KindEffect::effect);
  if (found != own.end()) return found->axes;
  return kind->has_other_effects() ? effect.axes : std::span<const std::string_view>();
}

Shown ShownOn(const Effect& effect, std::string_view axis, const MachineKind* kind) {
  const Sight& sight = *effect.sight;
  const bool is_other = kind->bed_is_on_screws() && sight.shown_on_screws != nullptr;
  Shown shown = is_other ? sight.shown_on_screws(axis) : sight.shown(axis);
  // Beside belts screws have columns of their own.
  const bool is_beside = kind->bed_is_on_screws() && kind->drive_map() != nullptr;
  const auto drive = DriveNamed(axis.substr(0, 2));
  if (!is_beside || !drive || !drive->is_screw) return shown;
  for (std::string& word : shown.covariates) {
    for (const std::string_view screw : kScrewAxes) {
      if (word == DriveCovariate(screw)) {
        word = "motor_" + std::string(screw);
        break;
      }
      if (word == SenseCovariate(screw)) {
        word = "dir_" + std::string(screw);
        break;
      }
    }
  }
  return shown;
}

std::optional<Bounds> DeclaredBounds(std::string_view effect,
                                     std::string_view parameter) {
  const auto index = FindEffect(effect);
  if (!index) return std::nullopt;
  const auto& parameters = EffectAt(*index).parameters;
  const auto found = std::ranges::find(parameters, parameter, &Parameter::name);
  if (found == parameters.end()) return std::nullopt;
  return Bounds{found->min, found->max};
}

bool HasAxis(const Effect& effect, std::string_view axis, const MachineKind* kind) {
  const auto same = [&](std::string_view word) {
    return word == axis || (word == kAnyAxis && !axis.empty());
  };
  return std::ranges::any_of(AxesOn(effect, kind), same) ||
         std::ranges::any_of(effect.aliases, same);
}

std::vector<KnobTurn<double>> TurnsOf(const Injected& effect) {
  std::vector<KnobTurn<double>> turns;
  const auto add = [&]<typename E>(int index, std::type_identity<E>) {
    if constexpr (requires { E::template Turns<double>(effect.axis, effect.values); }) {
      if (index != effect.effect) return;
      for (const KnobTurn<double>& turn :
           E::template Turns<double>(effect.axis, effect.values)) {
        if (turn.knob >= 0) turns.push_back(turn);
      }
    }
  };
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (add(static_cast<int>(kIndex),
         std::type_identity<std::tuple_element_t<kIndex, EffectList>>{}),
     ...);
  }(std::make_index_sequence<kNumEffects>{});
  return turns;
}

std::string AxisOf(const Effect& effect, std::string_view written) {
  const bool is_alias =
      std::ranges::find(effect.aliases, written) != effect.aliases.end();
  return std::string(is_alias ? effect.axes[0] : written);
}

std::vector<Injected> TurnBuild(std::span<const Injected> effects,
                                DeltaBuild<double>* build) {
  std::vector<Injected> others;
  DeltaBed<double> bed;  // No effect turns it: its shapes are the artefact's.
  for (const Injected& effect : effects) {
    const auto turns = TurnsOf(effect);
    for (const auto& [knob, by] : turns) TurnKnob(knob, by, build, &bed);
    if (turns.empty()) others.push_back(effect);
  }
  return others;
}

}  // namespace caltwin
