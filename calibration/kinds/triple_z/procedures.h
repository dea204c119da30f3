#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/kinds/triple_z/plane.h"
#include "calibration/kinds/triple_z/printer.h"
#include "calibration/kinds/triple_z/response.h"
#include "calibration/loop/outcome.h"

namespace caltwin {

/// What the triple-Z procedures have to choose.
struct TripleZOptions {
  bool is_as_published = false;
  int columns = 3, rows = 3;  ///< Of the probed grid.
  bool at_screws = false;     ///< Three touches, over the screws: the manual way.
  double margin_mm = 20;
  double reference_mm = 0;  ///< Where the bed is to be level (the published 10.0).
  OffsetRule rule = OffsetRule::kLevel;
  bool iterates = false;     ///< bed_tilt_iterated: foretold, then round by round.
  int rounds = 1;            ///< At most.
  double target_mm = 0.01;   ///< Mean error that ends rounds.
  double test_mm = 0.5;      ///< How far single screws are raised to be told apart.
  bool from_rounds = false;  ///< pivots_and_wiring: from two levelling rounds.
  double largest_mm = 10;    ///< Greater corrections are refused.
  bool holds_out = false;  ///< Afterwards, touches between the points that were fitted.
};

/// Result of a procedure, and the response of the screws where one was taken.
struct TripleZResult {
  ProcedureResult result{};
  std::optional<BedPlane> plane{};     ///< As it was found first.
  std::optional<LevelReport> level{};  ///< As it was left.
  /// The same between the points that were fitted: what the fit cannot flatter.
  std::optional<LevelReport> hold_out{};
  std::optional<ScrewResponse> response{};
  std::optional<double> predicted_factor{};  ///< Of each round, told beforehand.
  std::vector<double> steeper{};  ///< The tilt after each round over that before it.
};

/// probe_plane_tilt: touches a grid, fits z = a x + b y + c, reports.
TripleZResult RunPlaneTilt(TripleZPrinter* printer, const TripleZOptions& options);

/// calibrate_bed_tilt: the plane, what each screw is to be raised, apply, validate; one
/// round, or up to `rounds`. Corrected: in full, at the reference, undone where the
/// validation is worse; before the first of several rounds single screws are tried, and
/// a loop whose gain is not surely below 1 is refused. As published: by the rule,
/// whatever comes.
TripleZResult RunBedTilt(TripleZPrinter* printer, const TripleZOptions& options);

/// The firmware levels by its drivers (G30 P .. S3), up to `rounds`. Corrected: the
/// gain of its believed pivots is told first, and refused where it is not surely below
/// 1; a round that leaves it worse is undone.
TripleZResult RunRrfLevelling(TripleZPrinter* printer, const TripleZOptions& options);

/// Where the screws stand and which driver turns which, from single screws raised one
/// by one, or from two levelling rounds. Corrected: the firmware is told (M671).
TripleZResult RunPivotsAndWiring(TripleZPrinter* printer,
                                 const TripleZOptions& options);

}  // namespace caltwin
