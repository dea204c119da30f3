#pragma once

namespace caltwin {

/// P(F > f) of Fisher's F with so many degrees of freedom (need not be whole):
/// I_x(d2 / 2, d1 / 2), x = d2 / (d2 + d1 f), by the continued fraction of the
/// incomplete beta function (Abramowitz and Stegun 26.5.8). f >= 0, d1, d2 > 0.
double FUpperTail(double f, double d1, double d2);

}  // namespace caltwin
