#pragma once

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct PlaneTiltOptions {
  std::string artefact{};  ///< A plate; empty: the first, else the table itself.
  int columns = 3;         ///< Points along x.
  int rows = 3;            ///< Points along y.
  int repeats = 2;
  double margin_mm = 20;  ///< From the plate's edge, or the ends of travel.
  Place place{};
};

/// Tilt of a plate or the table against the machine's axes, by a grid of touches.
Expected<void> RunPlaneTilt(Session* session, const PlaneTiltOptions& options);

/// The grid's places, clear of what else stands there.
std::vector<Face> TiltGrid(Session* session, const PlaneTiltOptions& options);

PlaneTiltOptions ReadPlaneTilt(YamlMap* map);

extern const Procedure kPlaneTilt;

}  // namespace caltwin
