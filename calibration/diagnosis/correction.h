#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/controller.h"
#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// One file of a correction; the first has no suffix and says what it needs of the
/// others.
struct CorrectionFile {
  std::string suffix{};  ///< Behind the name that the user gave: "", ".x.comp".
  std::string text{};
};

/// What the controller's own settings can do against what was found: steps/mm,
/// backlash, squareness, a twisted beam's probing (Klipper), a screw table (LinuxCNC).
/// Each value stands with its unit and where it comes from; each finding that the
/// controller cannot carry is a comment that says so and what to do instead.
///
/// Conventions of the controllers, as their sources have them (signs: docs/signs.md):
///   RRF      M556: motor x = x + y X/S + z Z/S, motor y = y + z Y/S
///   Marlin   M852: motor x = x - I y - J z, motor y = y - K z
///   Klipper  [skew_correction]: as Marlin; axis_twist: read z += compensation(x)
///   LinuxCNC COMP_FILE_TYPE 0: motor = q + (nominal - actual), by direction; it
///            takes the place of BACKLASH
/// `name` is what the user calls the first file, by which it names the others.
/// Squareness is small: products of two angles are neglected (1e-6 of the travel).
std::vector<CorrectionFile> CorrectionOfAxes(ControllerKind controller,
                                             const Diagnosis& diagnosis,
                                             const Observed& observed,
                                             const std::string& name);

/// Axes of a gantry whose steps/mm its correction sets: those that these rows show to
/// be off.
std::vector<Axis> AxesOfNewSteps(const Diagnosis& diagnosis, const Observed& observed);

/// The correction of any kind of machine: what its own numbers can do (kinds/).
std::vector<CorrectionFile> CorrectionFor(ControllerKind controller,
                                          const Diagnosis& diagnosis,
                                          const Observed& observed,
                                          const std::string& name);

}  // namespace caltwin
