#pragma once

#include <span>

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// An expanded uncertainty U = k u with what it rests on (JCGM 100, 6.2 and annex G).
struct Expanded {
  double u = 0;  ///< Combined standard uncertainty.
  double dof = std::numeric_limits<double>::infinity();  ///< Effective, of u.
  double k = 1.959963984540054;                          ///< Coverage factor.
  double U = 0;  ///< value +- U holds the truth with the probability asked for.
};

/// Student's t for a two-sided interval that holds `probability`, e.g. 2.228 for 10
/// degrees of freedom and 0.95. Of dof that are no whole number the next lower one's
/// (JCGM 100, G.4.1), at least 1; from 1000 on the normal distribution's.
double CoverageFactor(double dof, double probability = 0.95);

/// Welch and Satterthwaite:  nu_eff = u^4 / sum(u_i^4 / nu_i)  (JCGM 100, G.2b), of
/// independent inputs; infinite where no input has few degrees of freedom.
double EffectiveDof(std::span<const Contribution> budget);

/// Combined standard uncertainty, u = sqrt(sum u_i^2).
double CombinedU(std::span<const Contribution> budget);

/// The line of an input x whose change moves the result by `c` of it: u = |c| u(x). The
/// sd of few degrees of freedom holds t / 1.96 (Uncertain), which u does not.
Contribution InputOf(const std::string& input, double c, const Given& x);

/// u = sqrt(sum u_i^2), k = t(nu_eff), U = k u.
///
/// The largest rectangular input is not taken for normal: k is that of the sum of a
/// rectangle and a normal number, 1.645 for the rectangle alone (EA-4/02 S9, S10),
/// widened by t(nu_eff) / 1.96. Further rectangles count as normal. No inputs: U = 0.
Expanded Expand(std::span<const Contribution> budget, double probability = 0.95);

/// An estimate with its budget; sd is U / 1.96. Inputs that add nothing are left out;
/// not identifiable where one is not known.
Uncertain WithBudget(double value, std::vector<Contribution> budget);

/// What an input adds once the result is `factor` times as much.
void ScaleInput(double factor, Contribution* input);

/// The same estimate in another unit, `factor` of which are one of this.
Uncertain Scaled(Uncertain estimate, double factor);

/// What a value adds that stands `offset` from its estimate and is not corrected for it
/// (JCGM 100, F.2.4.5): u such that +-1.96 hypot(sd, u) about the value hold 95 % of
///
///   offset + sd N(0, 1)
///
/// 0 without an offset; at most (offset + 1.645 sd) / 1.96 together with sd.
Contribution NotCorrected(double offset, double sd);

/// For people: inputs of one name as one line, their variances added.
std::vector<Contribution> ByInput(std::span<const Contribution> budget);

/// Adds an independent input to the budget and to sd; an estimate without a budget gets
/// its own sd as first line, called `own`.
Uncertain WithInput(Uncertain estimate,
                    const Contribution& input,
                    const std::string& own = "readings");

}  // namespace caltwin
