#pragma once

#include <span>
#include <string_view>

#include "sim/effects/effect.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// Where an effect acts in the physics.
enum class ActKind {
  kEditModel,    ///< Bodies, joints, springs of the model, before it is compiled.
  kDriveMap,     ///< Where the motors put the nuts: steps to position, the gap's width.
  kReadingMap,   ///< The tip's place and the probe's switch, while it runs.
  kTableMap,     ///< How the table stands under the tip, while it runs.
  kLinkBuild,    ///< Parts of a chain of rods, before its model is made (TurnsOf).
  kScrewBuild,   ///< Where a bed's screws stand, before its model is made.
  kStationMap,   ///< Parts of a printer's station, while it runs: ZStationMachine.
  kArtefactMap,  ///< Size and turn of what lies on the table: BuiltArtefacts.
};

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
