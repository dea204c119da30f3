#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace caltwin {

/// How the errors of numbers that one fit estimated go together:
///
///   r_ij = C_ij / sqrt(C_ii C_jj)
///
/// What is computed from several of them needs it:  u(a x + b y)^2 = a^2 u_x^2 + b^2
/// u_y^2 + 2 a b r u_x u_y  (JCGM 100, 5.2.2).
struct Correlations {
  std::string procedure{};           ///< Whose fit it is.
  std::vector<std::string> names{};  ///< As the estimates'.
  Eigen::MatrixXd matrix{};          ///< Symmetric, 1 on the diagonal; no unit.
};

/// From a covariance, rows and columns in the order of `names`, in any units. A number
/// without variance goes with nothing.
Correlations CorrelationsOf(std::string procedure,
                            std::vector<std::string> names,
                            const Eigen::MatrixXd& covariance);

struct CorrelatedPair {
  std::string first{}, second{};
  double r = 0;
};

/// The largest without sign, at most `most`, none below `least`.
std::vector<CorrelatedPair> LargestPairs(const Correlations& of,
                                         std::size_t most,
                                         double least);

/// "backlash.x with probe_pretravel.x -0.93, ...": the three largest of 0.1 and more,
/// and how many others there are of 0.3 and more; empty where there is none.
std::string MostCorrelatedText(const Correlations& of);

}  // namespace caltwin
