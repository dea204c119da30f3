#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renders/scene.h"
#include "scenarios/scenario.h"
#include "sim/machine/artefact.h"

namespace caltwin {

/// A machine ready to be drawn.
struct Still {
  std::string machine{};  ///< Its name.
  /// Where its tip goes along x, y and z: least and most. Where it has none, its axes.
  std::array<std::array<double, 2>, 3> travel_mm{};
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

/// What a twin is built from, and what lies on its table.
struct TwinFiles {
  std::filesystem::path machine{};
  std::filesystem::path truth{};  ///< Empty: as its own file says it was built.
  std::uint64_t seed = 1;
  std::vector<Artefact> artefacts{};
};

/// That twin with its hidden errors. Throws InputError, as where errors enlarged so far
/// leave no machine.
Still StillOf(const TwinFiles& twin, double exaggerate);

/// The machine of a run of that scenario, its errors drawn with that seed. Throws
/// InputError where errors enlarged so far leave no machine.
Still StillOf(const Scenario& scenario, std::uint64_t seed, double exaggerate);

/// How far an Enlarged machine's errors are enlarged.
struct Enlarged {
  Still still{};
  double exaggerate = 1;
};

/// The same, its errors enlarged that many times, or a half, a quarter, ... of it, as
/// far as the machine still holds together.
Enlarged EnlargedStillOf(const Scenario& scenario,
                         std::uint64_t seed,
                         double exaggerate);

}  // namespace caltwin
