#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "sim/effects/backlash.h"
#include "sim/effects/bed_tilt.h"
#include "sim/effects/effect.h"
#include "sim/effects/probe_pretravel.h"
#include "sim/effects/squareness.h"
#include "sim/effects/steps_per_mm.h"
#include "sim/effects/tip_size.h"
#include "sim/effects/trigger_latency.h"
#include "sim/effects/trigger_scatter.h"
#include "sim/effects/windup_load.h"

namespace caltwin {

/// Every effect there is, in the order reports list them; a new one is one line here
/// and one in sim/effects/acts/catalog.cc. The index in this list is `Valued::effect`.
using EffectList = std::tuple<StepsPerMm,
                              Backlash,
                              WindupLoad,
                              Squareness,
                              ProbePretravel,
                              TipSize,
                              TriggerLatency,
                              TriggerScatter,
                              BedTilt>;
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
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (void)((effect == static_cast<int>(kIndex) &&
            (std::tuple_element_t<kIndex, EffectList>::Add(asked, errors), true)) ||
           ...);
  }(std::make_index_sequence<kNumEffects>{});
}

}  // namespace caltwin
