#include "calibration/diagnosis/gates.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/diagnosis/outliers.h"
#include "sim/base/dense.h"

namespace caltwin {
namespace {

constexpr int kFewRows = 3;
constexpr double kKept = 0.3;  // Of its size, without them.

}  // namespace

Support SupportOf(const Observed& observed,
                  const Circumstances& circumstances,
                  double wander_mm2_per_s,
                  const Candidate& candidate,
                  const Weighed& weighed) {
  const Evidence evidence(observed,
                          {circumstances.sigma_mm, wander_mm2_per_s},
                          circumstances.nuisances,
                          circumstances.left_out);
  const Eigen::VectorXd shown = evidence.Left(evidence.Whiten(
      candidate.variants[weighed.variant].columns_mm * weighed.sizes_mm));
  const Eigen::VectorXd speaks =
      shown.cwiseProduct(evidence.Left(evidence.white_residual()));
  std::vector<std::size_t> order(static_cast<std::size_t>(speaks.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, std::ranges::greater{}, [&](std::size_t i) {
    return speaks[static_cast<Eigen::Index>(i)];
  });
  Circumstances without = circumstances;
  for (std::size_t k = 0; k < std::min<std::size_t>(kFewRows, order.size()); ++k) {
    without.left_out[order[k]] = true;
  }
  // The same variant: another one might live on other outliers.
  Candidate only = candidate;
  only.variants = {candidate.variants[weighed.variant]};
  const Weighed fewer = Weigh(observed, {only}, without).ranked[0];
  // Freedom of form may explain other rows, and speak for a cause that is gone.
  const Eigen::VectorXd still =
      evidence.Left(evidence.Whiten(only.variants[0].columns_mm * fewer.sizes_mm));
  Support support{.is_by_many = fewer.log_odds > 0 &&
                                shown.dot(still) > kKept * shown.squaredNorm()};
  const auto first = static_cast<Eigen::Index>(order[0]);
  const double left_sigma = evidence.Left(evidence.white_residual())(first);
  if (speaks[first] > 0.5 * speaks.cwiseMax(0).sum() &&
      std::abs(left_sigma) > kOutlier_sigma) {
    support.loudest = order[0];
  }
  return support;
}

double FormShare(const Evidence& evidence,
                 const Candidate& candidate,
                 const Weighed& weighed) {
  if (weighed.deviation_mm.size() == 0 || candidate.is_free()) return 0;
  const Eigen::VectorXd fitted_mm =
      candidate.variants[weighed.variant].columns_mm * weighed.sizes_mm;
  const Eigen::VectorXd whole =
      evidence.Left(evidence.Whiten(fitted_mm + weighed.deviation_mm));
  double least = Peak_mm(weighed.deviation_mm) / std::max(Peak_mm(fitted_mm), 1e-300);
  for (const Variant& variant : candidate.variants) {
    const Eigen::MatrixXd columns = evidence.Left(evidence.Whiten(variant.columns_mm));
    const Eigen::VectorXd sizes = LeastSquares(columns, whole);
    if (candidate.must_be_positive && sizes[0] < 0) continue;
    const Eigen::VectorXd own = columns * sizes;
    const double share = Peak_mm(whole - own) / std::max(Peak_mm(own), 1e-300);
    least = std::min(least, share);
  }
  return least;
}

double Separation(const Evidence& evidence,
                  const Eigen::VectorXd& effect_white,
                  const Candidate& rival) {
  const Eigen::VectorXd left = evidence.Left(effect_white);
  const double scale2 = evidence.chi2() / evidence.dof();
  const double whole = effect_white.dot(left);
  double least = whole;
  for (const Variant& variant : rival.variants) {
    const Eigen::MatrixXd white = evidence.Whiten(variant.columns_mm);
    Eigen::MatrixXd gram = evidence.Project(white).gram;
    gram.diagonal().array() += 1e-9 * (gram.diagonal().maxCoeff() + 1e-30);
    const Eigen::VectorXd match = white.transpose() * left;
    const Eigen::VectorXd sizes = Cholesky(gram).Solve(match);
    if (rival.must_be_positive && sizes[0] < 0) continue;
    least = std::min(least, whole - match.dot(sizes));
  }
  return least / scale2;
}

}  // namespace caltwin
