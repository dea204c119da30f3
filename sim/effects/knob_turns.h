#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "sim/effects/effect.h"
#include "sim/effects/linkage_at.h"

namespace caltwin {

/// What an effect turns of a delta's build: a knob, by an inside value. Knob -1: none.
template <typename T>
struct KnobTurn {
  int knob = -1;
  T by{};
};

/// Adds how the nozzle moves with these turns, about the machine as it is believed to
/// be built: its exact derivatives.
template <typename T, std::size_t kNum>
void AddTurns(const Asked<T>& asked,
              const std::array<KnobTurn<T>, kNum>& turns,
              Errors<T>* errors) {
  if (asked.at.linkage == nullptr) return;
  for (const KnobTurn<T>& turn : turns) {
    if (turn.knob < 0) continue;
    errors->motion_mm +=
        asked.at.linkage->by_knob.col(turn.knob).template cast<T>() * turn.by;
  }
}

/// A tower's index among a b c; 0 where it is none.
constexpr int TowerIndex(std::string_view axis) {
  return axis == "b" ? 1 : axis == "c" ? 2 : 0;
}

}  // namespace caltwin
