#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// The bed touched once more, each driver told to stand so much higher than at first.
struct RaisedTouches {
  Vec3<double> raised_mm = Vec3<double>::Zero();
  std::vector<BedTouch> touches{};
};

/// What the drivers do to the bed, whatever they are called and wherever their screws
/// stand: driver i raised by 1 lifts the bed over (x, y) by
///
///   R_i(x, y) = r_i0 + r_i1 x + r_i2 y,   R_1 + R_2 + R_3 = 1
struct ScrewResponse {
  bool is_told = false;
  Eigen::Matrix3d by_driver = Eigen::Matrix3d::Zero();  ///< Row i: r_i0 r_i1 r_i2.
  Pivots<double> at_mm{};     ///< Where the screw that each driver turns stands.
  Pivots<double> at_sd_mm{};  ///< Standard uncertainties, as in Uncertain.
  /// Of at_mm, x and y of the first driver first [mm^2]; u^2, degrees of freedom apart.
  Eigen::Matrix<double, 6, 6> at_covariance_mm2 = Eigen::Matrix<double, 6, 6>::Zero();
  /// What they were told by: the touches' own scatter, or somebody's statement.
  double dof = std::numeric_limits<double>::infinity();
  std::array<int, kNumScrews> screw_of{
      0, 1, 2};  ///< Of each driver, by nearest screws.
  double rms_mm = 0;
  double chi2_per_dof = 0;

  /// Of the six numbers that the drivers' responses are (first, second; 1, x, y), the
  /// unit direction of which the touches tell least; 0 where there is no fit.
  Eigen::Matrix<double, 6, 1> weakest = Eigen::Matrix<double, 6, 1>::Zero();
  /// The same by name ("response.z1.dx"), as an Observability has it.
  std::map<std::string, double> WeakestOf() const;

  double At(int driver, const Eigen::Vector2d& place_mm) const {
    return by_driver.row(driver).dot(Vec3<double>(1, place_mm[0], place_mm[1]));
  }
};

/// Least squares over all touches: the bed at first (a plane and its curvature), and
/// how each driver lifts it. Wants two raises that are not of all alike, nor along each
/// other; single screws one by one are best, the corrections of two levelling rounds
/// do. Then matches drivers to the drawn screws by the least sum of squared distances.
///
/// @param sigma_mm  standard uncertainty of one touch, stated by somebody or not
///                  (ScatterFactor)
ScrewResponse FitScrewResponse(std::span<const RaisedTouches> stands,
                               const Pivots<double>& drawn_mm,
                               double sigma_mm,
                               bool is_sigma_stated = true);

/// What a levelling round leaves of the heights over the screws as the firmware
/// believes them: G = I - A, A(k, j) = R_j(believed k). Each round multiplies by it;
/// with screws where they are believed it is 0.
Eigen::Matrix3d LevellingGain(const ScrewResponse& response,
                              const Pivots<double>& believed_mm);
/// The same from where screws stand, drivers in that order.
Eigen::Matrix3d LevellingGain(const Pivots<double>& standing_mm,
                              const Pivots<double>& believed_mm);
/// The largest factor by which a round multiplies an error: above 1 it diverges.
double SpectralRadius(const Eigen::Matrix3d& gain);

/// By what each round multiplies the tilt, and how sure that is by what told the
/// screws' places (first order).
struct LevellingFactor {
  double value = 0, sd = 0;

  bool converges() const { return value + 2 * sd < 1; }
  bool diverges() const { return value - 2 * sd >= 1; }
};
LevellingFactor FactorOf(const ScrewResponse& response,
                         const Pivots<double>& believed_mm);

/// "Z1 and Z2 are swapped", "pivot 2 is 31.0 +- 0.4 mm off (dx +25.0, dy -18.3)".
std::vector<std::string> WordsOfResponse(const ScrewResponse& response,
                                         const Pivots<double>& drawn_mm);
/// Guides that hold a bed level against screws that give (OverconstrainedBed) put every
/// apparent pivot further from the screws' middle, d_i' = d_i + h K^-1 d_i: the ratio
/// of stiffnesses h that all six coordinates together say, where it is above 3 standard
/// deviations and they scatter about that pattern no more than they should (chi
/// squared, 5 degrees of freedom, 99 %).
struct HeldBed {
  double stiffness_ratio_mm2 = 0, sd_mm2 = 0;
};
std::optional<HeldBed> HeldBedLike(const ScrewResponse& response,
                                   const Pivots<double>& drawn_mm);
/// "each round multiplies the tilt by 2.00: levelling diverges".
std::string WordsOfGain(const LevellingFactor& factor);

}  // namespace caltwin
