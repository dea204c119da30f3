#include "calibration/diagnosis/time_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "sim/base/dense.h"
#include "sim/base/median.h"

namespace caltwin {
namespace {

// In usual steps between rows; and parts of the variance.
constexpr std::array kTaus_steps = {2.5, 5.0, 10.0, 25.0, 80.0};
constexpr std::array kShares = {0.3, 0.6, 0.85, 0.97};

}  // namespace

TimeNoise::TimeNoise(const Observed& observed,
                     const Noise& noise,
                     const std::vector<Nuisance>& nuisances,
                     const std::vector<bool>& left_out) {
  const auto q = static_cast<Eigen::Index>(nuisances.size());
  of_nuisances_ = Eigen::VectorXd::Ones(q);
  const Evidence evidence(observed, noise, nuisances, left_out);
  FindStreams(observed, left_out);
  if (!HangsTogether(evidence.Left(evidence.white_residual()))) return;
  const Evidence still(observed, {noise.sigma_mm, 0}, nuisances, left_out);
  Eigen::MatrixXd columns_mm(observed.num_rows(), q);
  Eigen::VectorXd prior_sds(q);
  for (Eigen::Index k = 0; k < q; ++k) {
    columns_mm.col(k) = nuisances[static_cast<std::size_t>(k)].column_mm;
    prior_sds[k] = nuisances[static_cast<std::size_t>(k)].prior_sd;
  }
  Eigen::MatrixXd all(observed.num_rows(), q + 1);
  all.leftCols(q) = still.Whiten(columns_mm) * prior_sds.asDiagonal();
  all.col(q) = still.white_residual();
  Weigh(all, still.log_none(), evidence.log_none());
  // A value is its covariance times what its column and the others say of the rows.
  const Evidence::Fit fit = evidence.FitNuisances();
  const double scale2 = evidence.chi2() / evidence.dof();
  Eigen::MatrixXd weights =
      evidence.Whiten(columns_mm) * fit.half * fit.half.transpose() / scale2;
  const Eigen::VectorXd own = scale2 * weights.colwise().squaredNorm().transpose();
  if (noise.wander_mm2_per_s > 0) {
    const Eigen::MatrixXd sigmas = noise.sigma_mm.asDiagonal();
    weights = evidence.Whiten(sigmas).transpose() * weights;
  }
  of_nuisances_ = Inflation(weights, own);
}

void TimeNoise::Weigh(const Eigen::MatrixXd& columns, double still, double as_fitted) {
  World white;
  const double offset = still - LogLikelihood(columns, &white);
  std::vector<double> logs = {as_fitted};
  worlds_ = {{}};
  for (const double tau_steps : kTaus_steps) {
    for (const double share : kShares) {
      worlds_.push_back({.tau_steps = tau_steps, .share = share});
      logs.push_back(offset + LogLikelihood(columns, &worlds_.back()) -
                     std::log(kTaus_steps.size() * kShares.size()));
    }
  }
  const double most = *std::ranges::max_element(logs);
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - most);
  for (std::size_t i = 0; i < worlds_.size(); ++i) {
    worlds_[i].weight = std::exp(logs[i] - most) / sum;
  }
}

void TimeNoise::FindStreams(const Observed& observed,
                            const std::vector<bool>& left_out) {
  std::map<std::string, std::vector<Eigen::Index>> streams;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (!left_out.empty() && left_out[static_cast<std::size_t>(i)]) continue;
    Eigen::Index axis = 0;
    observed.at(i).n.cwiseAbs().maxCoeff(&axis);
    streams[observed.row(i).campaign + "|" + std::to_string(axis)].push_back(i);
  }
  for (auto& [name, rows] : streams) {
    std::ranges::stable_sort(
        rows, {}, [&](Eigen::Index i) { return observed.row(i).row; });
    std::vector<double> steps_s = {0};
    for (std::size_t k = 1; k < rows.size(); ++k) {
      steps_s.push_back(observed.at(rows[k]).t_s - observed.at(rows[k - 1]).t_s);
    }
    const double usual_s = observed.has_times() ? Median(steps_s) : 0;
    Stream stream;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double steps = usual_s > 0 ? std::max(steps_s[k], 0.0) / usual_s : 1;
      stream.push_back({rows[k], steps});
    }
    streams_.push_back(std::move(stream));
  }
}

// Neighbours of the first three orders, against what white noise does once in some
// thousand times.
bool TimeNoise::HangsTogether(const Eigen::VectorXd& residual) const {
  constexpr std::size_t kOrders = 3;
  constexpr double kMost = 12;
  double together = 0;
  for (std::size_t order = 1; order <= kOrders; ++order) {
    double sum = 0, squares = 0, pairs = 0;
    for (const Stream& stream : streams_) {
      for (std::size_t k = order; k < stream.size(); ++k) {
        const double product =
            residual[stream[k].row] * residual[stream[k - order].row];
        sum += product;
        squares += product * product;
        pairs += 1;
      }
    }
    if (pairs > 0 && sum > 0) together += sum * sum / std::max(squares, 1e-300);
  }
  return together > kMost;
}

double TimeNoise::Whiten(const World& world, Eigen::MatrixXd* columns) const {
  double log_det = 0;
  for (const Stream& stream : streams_) {
    Eigen::RowVectorXd state = Eigen::RowVectorXd::Zero(columns->cols());
    double open = world.share;  // Variance of the part that fades.
    for (const Reading& at : stream) {
      const double fades =
          world.share > 0 ? std::exp(-at.steps / world.tau_steps) : 0.0;
      state *= fades;
      open = world.share - fades * fades * (world.share - open);
      const double variance = open + 1 - world.share;
      const Eigen::RowVectorXd innovation = columns->row(at.row) - state;
      state += innovation * (open / variance);
      open *= 1 - open / variance;
      columns->row(at.row) = innovation / std::sqrt(variance);
      log_det += std::log(variance);
    }
  }
  return log_det;
}

double TimeNoise::LogLikelihood(const Eigen::MatrixXd& columns, World* world) const {
  const Eigen::Index n = columns.rows(), q = columns.cols() - 1;
  Eigen::MatrixXd tall(n + q, q + 1);
  tall.topRows(n) = columns;
  Eigen::MatrixXd top = columns;
  const double log_det = Whiten(*world, &top);
  tall.topRows(n) = top;
  tall.bottomRows(q).setZero();
  tall.bottomLeftCorner(q, q).setIdentity();
  const Eigen::MatrixXd upper = QrOf(tall).R();
  const double chi2 = std::max(upper(q, q) * upper(q, q), 1e-30);
  const Eigen::MatrixXd inverse = InverseOfUpper(upper.topLeftCorner(q, q));
  double rows = 0;
  for (const Stream& stream : streams_) rows += static_cast<double>(stream.size());
  const double paid = static_cast<double>(q) - inverse.squaredNorm();
  const double dof = std::max(1.0, rows - paid);
  world->scale2 = chi2 / dof;
  return -0.5 * log_det - upper.diagonal().head(q).array().abs().log().sum() -
         0.5 * dof * std::log(chi2);
}

Eigen::VectorXd TimeNoise::Faded(double tau_steps,
                                 const Eigen::MatrixXd& weights) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(weights.cols());
  for (const Stream& stream : streams_) {
    Eigen::RowVectorXd before = Eigen::RowVectorXd::Zero(weights.cols());
    for (const Reading& at : stream) {
      before *= std::exp(-at.steps / tau_steps);
      const auto own = weights.row(at.row).array();
      sums += (own * (own + 2 * before.array())).matrix().transpose();
      before += weights.row(at.row);
    }
  }
  return sums;
}

Eigen::VectorXd TimeNoise::Inflation(const Eigen::MatrixXd& weights,
                                     const Eigen::VectorXd& own) const {
  constexpr double kNothing = 1e-4;
  const Eigen::VectorXd white = weights.colwise().squaredNorm().transpose();
  Eigen::VectorXd variance = worlds_[0].weight * own;
  for (const World& world : worlds_) {
    if (world.share == 0 || world.weight < kNothing) continue;
    variance +=
        world.weight * world.scale2 *
        ((1 - world.share) * white + world.share * Faded(world.tau_steps, weights));
  }
  Eigen::VectorXd inflation = Eigen::VectorXd::Ones(own.size());
  for (Eigen::Index k = 0; k < own.size(); ++k) {
    if (own[k] > 0) inflation[k] = std::sqrt(std::max(1.0, variance[k] / own[k]));
  }
  return inflation;
}

}  // namespace caltwin
