#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/covariate.h"
#include "calibration/diagnosis/free_form.h"

namespace caltwin {

/// A part of a table that has a name, as these rows tell it.
///
///   straight  the nearest line, from the first place to the last
///   bow       of the middle over the line through the ends, + up
///   cubic     of an S over the line through the ends, + in the second half
///   twist     of the corners (+, +) and (-, -) over the others, half of it
///   waves     the wave that explains most of the rest: its amplitude
///   rest      what no part names: root mean square over the places
///
/// Of a surface straight and bow come once an axis, and cubic is a root mean square.
struct TablePart {
  std::string name{};
  std::string along{};  ///< Word of the covariate; of a surface's whole: empty.
  double size_um = 0;
  double sd_um = 0;
  double period = 0;  ///< Of waves, in the covariate's unit; 0 else.
};

/// Coefficients of a table's terms, and their covariance half half'.
struct TableFit {
  Eigen::VectorXd sizes_mm{};
  Eigen::MatrixXd half_mm{};
};

/// Splits the sum of terms over the places of these rows, by least squares: Legendre's
/// polynomials of up to the third degree first, then one wave. The sds are those of the
/// coefficients, to first order. Empty where a covariate goes round, or has fewer than
/// three places. `shows`: rows that the table is of.
std::vector<TablePart> PartsOfTable(const std::vector<Covariate>& covariates,
                                    const std::vector<FreeTerm>& terms,
                                    const TableFit& fit,
                                    const std::vector<bool>& shows);

}  // namespace caltwin
