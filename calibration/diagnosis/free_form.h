#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/covariate.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// Orders of one term in its covariates. 0: constant there; -1: a line over their
/// range, -2: a bow, k > 0: a cosine of k half-waves; of a periodic one waves.
struct FreeTerm {
  int first = 0, second = 0;
};

/// Which terms of two covariates a form has.
enum class TermsOfTwo {
  kProducts,  ///< What neither covariate makes alone: a form of each stands beside it.
  kAll,       ///< Also those of one alone: a dent or a rim is no product.
};

/// The terms that one or two covariates can carry: a line, a bow and up to ten cosines,
/// of two together those of a few orders, of a sense itself.
std::vector<FreeTerm> TermsOf(const std::vector<Covariate>& covariates,
                              TermsOfTwo which = TermsOfTwo::kProducts);

/// A term's value where the covariates have these values.
double ProductAt(const FreeTerm& term,
                 const std::vector<Covariate>& covariates,
                 const std::vector<double>& values);

/// A smooth function of one or two covariates in one channel, a sum of terms whose
/// prior variance falls with their order. What "unknown structure in {x}" is made of.
struct FreeForm {
  std::string channel{};
  std::vector<std::string> words{};  ///< Of its covariates.
  std::vector<Covariate> covariates{};
  std::vector<FreeTerm> terms{};
  Eigen::MatrixXd columns_mm{};  ///< Rows by terms; each term at most 1.
  Eigen::VectorXd prior{};       ///< Relative variance of each, sums to 1.
};

/// The block over these rows, its lowest terms; no columns where a covariate is unknown
/// or does not vary, or the channel does not show.
FreeForm FreeFormOf(const Observed& observed,
                    const std::string& channel,
                    const std::vector<std::string>& words,
                    int most_terms,
                    TermsOfTwo which = TermsOfTwo::kProducts);

/// Whether a covariate is an axis of a gantry that no row commands a millimetre from
/// another. Touches of what stands at one height still end at heights a little apart:
/// those are the readings, and no position that could explain them. False for what is
/// no axis.
bool IsSliver(const Observed& observed, const std::string& word);

/// The blocks worth asking of a table: every channel that shows, with the covariates
/// that could rule it, direction x time and direction x temperature among them.
///
/// On a printer, whose nozzle touches its bed from above, what a bed or the nozzle's
/// height does over the place has all terms of x and y.
std::vector<FreeForm> AllFreeForms(const Observed& observed);

}  // namespace caltwin
