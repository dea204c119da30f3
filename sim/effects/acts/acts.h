#pragma once

#include <span>
#include <string_view>

#include "sim/effects/effect.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// Where an effect acts in the physics. What is no edit of the model acts where the
/// physics plant reads the closed form's numbers: the drive map (steps to motor
/// position) or the probe's switch (threshold, latency, scatter).
enum class ActKind { kEditModel, kDriveMap, kReadingMap };

struct ActOf {
  int effect = 0;
  ActKind kind = ActKind::kEditModel;
  /// For kEditModel: changes the model; values in file units, as declared. At its
  /// neutral values it changes nothing.
  void (*edit)(const Machine& machine, const Injected& injected, Mjcf* model) = nullptr;
};

/// One for each effect of the catalog, in its order.
std::span<const ActOf> AllActs();

/// Applies every injected effect that edits the model.
void EditModel(const Machine& machine, std::span<const Injected> effects, Mjcf* model);

}  // namespace caltwin
