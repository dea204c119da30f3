#pragma once

#include <vector>

#include "calibration/kinds/delta/g33_tune.h"

namespace caltwin {

/// One touch of a G33 grid, and how much of its height goes to each of the seven
/// points.
struct G33Touch {
  double x_mm = 0;
  double y_mm = 0;
  G33Heights share = G33Heights::Zero();
};

/// The grid P`points` (0 to 10) of that radius.
///
/// Centre points lie on a circle of a tenth of the radius, and their heights are
/// averaged. From P4 up, a radius point between two of the six gives cos^2 of its
/// height to the nearer and sin^2 to the farther (the angle counts 90 deg from one of
/// the six to the next), which passes 93, 74 and 50 % of the harmonics 1, 2 and 3 of
/// the height around the circle as the points grow many. From P8 up the points lie on
/// three circles, of 1, 0.9 and 0.8 times the radius.
/// @param opposite P2 touches between the towers instead of at them.
std::vector<G33Touch> G33Grid(int points,
                              double radius_mm,
                              bool opposite,
                              G33Variant variant);

/// The share of the harmonic (0 to 3) that the sin^2 and cos^2 split passes, of
/// `per_sixth` touches in every 60 deg.
double G33Passes(int harmonic, int per_sixth);

/// The heights whose harmonics around the circle are those given, over what was passed.
G33Heights G33Restored(const G33Heights& heights_mm, int per_sixth);

/// Touches in every 60 deg of the circle: 0 for P0 to P2.
int G33PerSixth(int points, G33Variant variant);

}  // namespace caltwin
