#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/estimate/linear_fit.h"
#include "calibration/kinds/delta/bench.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// The nine numbers of Klipper's model, in this order; the first six are all that it
/// moves where there are no distances.
inline constexpr std::array kKlipperNames = {"delta_radius",
                                             "endstop.a",
                                             "endstop.b",
                                             "endstop.c",
                                             "tower_angle.a",
                                             "tower_angle.b",
                                             "arm_length.a",
                                             "arm_length.b",
                                             "arm_length.c"};
inline constexpr int kKlipperSix = 6;
inline constexpr int kKlipperNine = 9;

/// A least squares fit of the first six or all nine of those numbers.
struct KlipperFit {
  bool is_converged = false;
  DeltaModel<double> model{};
  double height_rms_mm = 0;            ///< Of nozzle heights less what they were.
  double distance_rms_mm = 0;          ///< 0 without distances.
  std::vector<double> residuals_mm{};  ///< Height by the model less the true one.
  /// Of the parameters in mm (angles as arcs at the delta radius): covariance for the
  /// sigmas of the readings, and the directions nothing is told of.
  LinearFit last_step{};
};

/// Minimises  sum ((z_i - height_i) / sigma_i)^2 + sum ((d_j - length_j) / sigma_j)^2
/// over the first `num_parameters` of kKlipperNames by Gauss-Newton with exact
/// derivatives, from `start`. Not converged: the data do not reach the model's minimum
/// (fewer readings than parameters have no minimum, the least-norm step is taken).
KlipperFit FitKlipperModel(std::span<const DeltaTouch> touches,
                           std::span<const DeltaDistance> distances,
                           const DeltaModel<double>& start,
                           int num_parameters);

/// Heights by the model less the true ones.
std::vector<double> HeightResiduals_mm(std::span<const DeltaTouch> touches,
                                       const DeltaModel<double>& model);
/// Root of the mean square; 0 of nothing.
double RootMeanSquare(std::span<const double> values);

/// The sigma of a distance with which least squares weighs it against `num_touches` of
/// `touch_sigma_mm` as Klipper does: it counts a squared height num_distances / (0.5
/// num_touches) times a squared distance.
double KlipperDistanceSigma_mm(double touch_sigma_mm,
                               std::size_t num_touches,
                               std::size_t num_distances);

/// Whether a saved geometry is that of the touches saved beside it.
enum class SavedVerdict {
  kBelongs,        ///< A fit of the touches ends at what was saved.
  kMovedTogether,  ///< All three endstops were moved by the same amount since.
  kStale           ///< It is another calibration's, or was changed by hand.
};
std::string Name(SavedVerdict verdict);

/// A saved calibration beside a fit of its own data.
struct KlipperAssessment {
  SavedVerdict verdict = SavedVerdict::kBelongs;
  double saved_rms_mm = 0;   ///< Of the heights by the saved geometry.
  double saved_mean_mm = 0;  ///< Their mean: an offset of the bed as a whole.
  KlipperFit fit{};          ///< Of six numbers, of nine with distances.
  /// Root mean square of each touch's height as the others foretell it; nullopt where
  /// leaving one out leaves fewer readings than parameters.
  std::optional<double> hold_out_rms_mm{};
  int spare = 0;  ///< Readings beyond the parameters.
  /// What heights do not tell: the fit with all arms a millimetre longer.
  double longer_arms_rms_mm = 0;
  double longer_arms_radius_mm = 0;  ///< Change of the delta radius that goes along.
  double longer_arms_scale = 0;      ///< How much larger it would print, as a fraction.
};

/// Fits nine numbers where there are distances, else six, and compares. Stale: a number
/// differs from the fit's by 10 um (angles as arcs; the delta radius by 5), all three
/// endstops together excepted.
KlipperAssessment AssessKlipper(std::span<const DeltaTouch> touches,
                                std::span<const DeltaDistance> distances,
                                const DeltaModel<double>& saved);

}  // namespace caltwin
