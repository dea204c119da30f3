#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/estimate/joint.h"
#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"
#include "calibration/procedures/scale_doubt.h"

namespace caltwin {

struct JointOptions {
  /// What uncertainties rest on.
  enum class Scatter {
    kStated,  ///< The noise stated, unless the residuals contradict it.
    kRows,    ///< Each row's own residual (HC3).
    kGroups   ///< Residuals of a face's touches together (CR3).
  };

  std::vector<Axis> axes{kAxes.begin(), kAxes.end()};
  std::string artefact{};
  std::vector<double> sizes_mm{25.4, 76.2};
  int repeats = 5;
  bool measure = true;        ///< false: only the rows recorded so far.
  bool use_recorded = false;  ///< Those too, beside the ones measured now.
  bool tilt = true;           ///< Touch the plate or the table on a grid.
  bool squareness = false;    ///< Touch side faces at two places each.
  bool robust = false;        ///< Huber's loss.
  bool profile = false;       ///< Intervals by profile likelihood too.
  Scatter scatter = Scatter::kStated;
  /// Standard uncertainty of steps/mm, as a fraction, of axes that are not among `axes`
  /// and that nobody has measured.
  double steps_doubt = kScaleDoubt;
  bool verify = true;
  std::optional<Given> hysteresis_mm{};
  std::optional<Given> tip_radius_mm{};
  LoopRules rules{};
  Place place{};
};

/// The campaign: block touched in two sizes an axis, with releases at two feeds on one
/// of them, a grid on the table, side faces for squareness, a ledge where there is one.
/// All with compensation off, so that one placement holds for all rows.
Expected<void> MeasureJointCampaign(Session* session, const JointOptions& options);

/// Problem of those rows: steps/mm, backlash, pre-travel of each axis, bed tilt, tip
/// size, latency, squareness; with the declared priors.
JointProblem MakeJointProblem(Session* session,
                              const JointOptions& options,
                              const std::vector<Row>& rows);

/// The project's own estimate of everything from all rows at once; applied in the loop.
Expected<void> RunJoint(Session* session, const JointOptions& options);

extern const Procedure kJointEstimate;

}  // namespace caltwin
