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

/// The terms that one or two covariates can carry: a line, a bow and up to ten cosines,
/// of two together those of a few orders, of a sense itself.
std::vector<FreeTerm> TermsOf(const std::vector<Covariate>& covariates);

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
  Eigen::MatrixXd columns_mm{};  ///< Rows by terms; each term at most 1.
  Eigen::VectorXd prior{};       ///< Relative variance of each, sums to 1.
};

/// The block over these rows, its lowest terms; no columns where a covariate is unknown
/// or does not vary, or the channel does not show.
FreeForm FreeFormOf(const Observed& observed,
                    const std::string& channel,
                    const std::vector<std::string>& words,
                    int most_terms);

/// The blocks worth asking of a table: every channel that shows, with the covariates
/// that could rule it, direction x time and direction x temperature among them.
std::vector<FreeForm> AllFreeForms(const Observed& observed);

}  // namespace caltwin
