#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "renders/scene.h"

namespace caltwin {

/// A machine ready to be drawn.
struct Still {
  std::shared_ptr<void> scene{};
  const mjModel* model = nullptr;
  mjData* data = nullptr;
  /// Tip or nozzle there, in the machine's axes [mm]; false where it does not reach.
  /// Empty: it has none.
  std::function<bool(const Vec3<double>& tip_mm)> move_to{};
};

/// The machine that a file describes: as its file (or extension) says it was built, or
/// that of a scenario with its effects and artefacts. Throws InputError.
Still StillOf(const std::filesystem::path& file, double exaggerate);

}  // namespace caltwin
