#pragma once

#include <filesystem>
#include <memory>

#include "renders/scene.h"

namespace caltwin {

/// A machine ready to be drawn once.
struct Still {
  std::shared_ptr<void> scene{};
  const mjModel* model = nullptr;
  mjData* data = nullptr;
};

/// The machine that a file describes: as its file (or extension) says it was built, or
/// that of a scenario with its effects and artefacts. Throws InputError.
Still StillOf(const std::filesystem::path& file, double exaggerate);

}  // namespace caltwin
