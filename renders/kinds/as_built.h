#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renders/run_pictures.h"
#include "scenarios/scenario.h"

namespace caltwin {

/// How many times errors are enlarged in a report's pictures.
inline constexpr double kExaggerate = 30;

/// Of a report's pictures.
inline PictureOptions RunPictureOptions() {
  return {.width = 960, .height = 720};
}

/// The pictures of a run of what is no gantry: a delta's or a triple-Z printer's as
/// built, none of motors and of a nozzle's height. nullopt: it is a gantry's.
std::optional<std::vector<ReportPicture>> PicturesOfKind(const Scenario& scenario,
                                                         std::uint64_t seed);

}  // namespace caltwin
