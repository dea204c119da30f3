#pragma once

#include <Eigen/Core>

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// Which text of G33 is followed (docs/delta-engines.md).
enum class G33Variant {
  /// P6 has 36 radius points; the split by sin^2 and cos^2 is left as it is; the
  /// angles'
  /// matrix is inverted with 1 / x.
  kAsPublished,
  /// P6 has 30; what the split holds back is given again; a pseudo-inverse.
  kCorrected
};

/// Heights at the seven points of G33: the centre, then at the calibration radius tower
/// a (210 deg), between a and b (270 deg), b, between b and c, c, between c and a.
using G33Heights = Eigen::Matrix<double, 7, 1>;

/// Corrections that G33 computes from them: three endstops (M666's; one that grows
/// lowers the nozzle's believed height), radius [mm], three tower angles [deg].
using G33Matrix = Eigen::Matrix<double, 7, 7>;

/// Scale factors of the matrices, which make them fit this printer.
struct G33Factors {
  double h = 0;  ///< Endstops [mm/mm].
  double r = 0;  ///< Radius [mm/mm].
  double a = 0;  ///< Tower angles [deg/mm].
};

/// How far the seven points rise when the carriages do so by `carriages_mm` (column a
/// point, row a tower): G33's linear forward kinematics,
///
///   z = sum_i (1 + 2 q cos(angle to tower i)) / 3 carriage_i,   q = at / radius
///
/// exact at the centre only. It neglects that rods stand less steep the farther their
/// tower: with q = 0.77 and arms of 250 mm, 6 % at a tower and more between towers.
G33Heights G33Forward(const Eigen::Matrix<double, 3, 7>& carriages_mm,
                      double at_mm,
                      double radius_mm);

/// Carriage heights (less the endstops') of the seven points by the exact inverse
/// kinematics of three rods.
Eigen::Matrix<double, 3, 7> G33Carriages_mm(const DeltaModel<double>& settings,
                                            double at_mm);

/// auto_tune_h: 2/3 over the ratio of calibration radius to delta radius. Endstops
/// overshoot by radius^2 / (2 height^2) near the centre, 18 % of a usual printer.
double G33TuneH(const DeltaModel<double>& settings, double at_mm);
/// auto_tune_r: 1 / (3 x mean fall of the six per mm of radius), against the centre.
double G33TuneR(const DeltaModel<double>& settings, double at_mm);
/// auto_tune_a: 1 / (3 x rise per degree); the rise is half the difference of the
/// points clockwise and counter-clockwise of the tower that turns, averaged over the
/// towers.
double G33TuneA(const DeltaModel<double>& settings, double at_mm);

G33Factors G33Tuned(const DeltaModel<double>& settings, double at_mm);

/// The inverse of the 3x3 displacement matrix of the tower angles, [0 1 -1; -1 0 1; 1
/// -1 0], of rank 2: `x` is added to each element to invert it and taken out again. As
/// published by -1 / x, corrected by -1 / (9 x), which leaves the pseudo-inverse. The
/// published one is off by -8 / (9 x) in every element: an angle common to all towers,
/// which the rule that the three sum to nought takes out again.
Eigen::Matrix3d G33AngleInverse(G33Variant variant, double x);

/// What is calibrated.
struct G33Case {
  int points = 4;  ///< P: 0 nothing, 1 height, 2 + endstops and radius, 3 and more all.
  bool tower_angles = true;  ///< False with T.
};

/// The normalised inverted displacement matrix.
G33Matrix G33Correction(const G33Case& what,
                        const G33Factors& factors,
                        G33Variant variant);

}  // namespace caltwin
