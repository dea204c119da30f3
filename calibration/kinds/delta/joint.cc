#include "calibration/kinds/delta/joint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calibration/kinds/delta/joint_budget.h"
#include "sim/base/dense.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {
namespace {

constexpr double kNotThere = 1e6;  // Residual in sigma of a chain that does not close.

/// Residuals in sigma with their derivatives by the knobs' inside values.
struct Rows {
  Eigen::VectorXd residual{};
  Eigen::MatrixXd slope{};
};

/// Residuals and slopes of readings at a machine; remembers the poses, near which those
/// of the next machine are.
class ReadDelta {
 public:
  explicit ReadDelta(const DeltaReadings& readings, std::vector<int> knobs)
      : readings_(readings),
        knobs_(std::move(knobs)),
        poses_(readings.touches.size() + 2 * readings.distances.size()) {}

  Rows At(const DeltaBuild<double>& build, const DeltaBed<double>& bed) {
    const auto num = static_cast<Eigen::Index>(
        readings_.touches.size() + readings_.distances.size() + readings_.rods.size());
    Rows rows{Eigen::VectorXd(num),
              Eigen::MatrixXd::Zero(num, static_cast<Eigen::Index>(knobs_.size()))};
    std::size_t pose = 0;
    Eigen::Index i = 0;
    for (const DeltaTouch& touch : readings_.touches) {
      rows.residual[i] = kNotThere;
      if (const auto closed = Close(build, touch.motors_mm, pose++)) {
        std::array<double, kNumDeltaKnobs> slopes{};
        const double height_mm = closed->HeightOver(bed, &slopes);
        rows.residual[i] = (height_mm - touch.height_mm) / touch.sigma_mm;
        Take(slopes, 1 / touch.sigma_mm, i, &rows);
      }
      ++i;
    }
    for (const DeltaDistance& between : readings_.distances) {
      AddDistance(build, between, pose, i++, &rows);
      pose += 2;
    }
    for (const DeltaRodLength& rod : readings_.rods) AddRod(build, rod, i++, &rows);
    return rows;
  }

 private:
  std::optional<ClosedDelta> Close(const DeltaBuild<double>& build,
                                   const Vec3<double>& motors_mm,
                                   std::size_t pose) {
    auto& known = poses_[pose];
    auto closed = ClosedDelta::At(build, motors_mm, known ? &*known : nullptr);
    if (!closed && known) closed = ClosedDelta::At(build, motors_mm);
    if (closed) known = closed->pose();
    return closed;
  }

  void AddDistance(const DeltaBuild<double>& build,
                   const DeltaDistance& between,
                   std::size_t pose,
                   Eigen::Index i,
                   Rows* rows) {
    rows->residual[i] = kNotThere;
    const auto from = Close(build, between.from_mm, pose);
    const auto to = Close(build, between.to_mm, pose + 1);
    if (!from || !to) return;
    const Vec3<double> way = to->pose().nozzle_mm - from->pose().nozzle_mm;
    const double length_mm = way.norm();
    rows->residual[i] = (length_mm - between.length_mm) / between.sigma_mm;
    Take(to->Slopes(way / length_mm), 1 / between.sigma_mm, i, rows);
    Take(from->Slopes(-way / length_mm), 1 / between.sigma_mm, i, rows);
  }

  void AddRod(const DeltaBuild<double>& build,
              const DeltaRodLength& read,
              Eigen::Index i,
              Rows* rows) const {
    const auto rod = static_cast<std::size_t>(read.rod);
    const double own_mm = build.rod_error_mm[rod];
    const double length_mm = build.model.arm_mm[rod / 2] + own_mm;
    rows->residual[i] = (length_mm - read.length_mm) / read.sigma_mm;
    std::array<double, kNumDeltaKnobs> slopes{};
    slopes[kArmKnob] = slopes[kRodKnob + rod] = 1;
    Take(slopes, 1 / read.sigma_mm, i, rows);
  }

  void Take(const std::array<double, kNumDeltaKnobs>& slopes,
            double scale,
            Eigen::Index i,
            Rows* rows) const {
    for (std::size_t k = 0; k < knobs_.size(); ++k) {
      rows->slope(i, static_cast<Eigen::Index>(k)) +=
          scale * slopes[static_cast<std::size_t>(knobs_[k])];
    }
  }

  const DeltaReadings& readings_;
  std::vector<int> knobs_;
  std::vector<std::optional<DeltaPose<double>>> poses_;
};

/// The estimate on its way: machine, knobs as turned, priors.
class Fitter {
 public:
  Fitter(const DeltaBuild<double>& drawn,
         const DeltaReadings& readings,
         const DeltaJointOptions& options)
      : drawn_(drawn),
        readings_(readings),
        options_(options),
        machine_(readings, options.knobs) {
    for (const int knob : options.knobs) {
      const auto at = static_cast<std::size_t>(knob);
      const DeltaKnob& is = kDeltaKnobs[at];
      const double usual_sd = PriorSdOf(knob, drawn) / is.per_unit;
      const double sd = options.prior_sd.empty() ? usual_sd : options.prior_sd[at];
      const bool has_mean = !options.prior_mean.empty();
      const double mean = has_mean ? options.prior_mean[at] : 0;
      prior_.push_back(sd * is.per_unit);
      believed_.push_back(mean * is.per_unit);
      reach_.push_back(is.prior_sd * is.per_unit);
    }
    turned_ = Eigen::Map<const Eigen::VectorXd>(
        believed_.data(), static_cast<Eigen::Index>(believed_.size()));
  }

  DeltaJointFit Fit() {
    constexpr int kMostRounds = 60;
    constexpr double kStill = 1e-7;  // Of a standard deviation.
    DeltaJointFit fit;
    Rows rows = At(turned_);
    double cost = Cost(rows, turned_);
    double damping = 0;
    for (; fit.rounds < kMostRounds; ++fit.rounds) {
      const Eigen::MatrixXd normal = Normal(rows);
      const Eigen::VectorXd step = Step(rows, normal, damping);
      const Eigen::VectorXd to = turned_ + step;
      const Rows there = At(to);
      const double cost_there = Cost(there, to);
      const double size = std::sqrt(std::max(0.0, step.dot(normal * step)));
      if (!(cost_there <= cost + 1e-9 * (1 + cost))) {
        damping = damping == 0 ? 1e-3 : damping * 10;
        if (damping > 1e8) break;
        continue;
      }
      turned_ = to;
      rows = there;
      cost = cost_there;
      damping = damping < 1e-6 ? 0 : damping / 10;
      if (size < kStill) {
        fit.converged = true;
        break;
      }
    }
    Report(rows, &fit);
    return fit;
  }

 private:
  Rows At(const Eigen::VectorXd& turned) {
    DeltaBuild<double> build = drawn_;
    DeltaBed<double> bed;
    Turn(turned, &build, &bed);
    return machine_.At(build, bed);
  }

  void Turn(const Eigen::VectorXd& turned,
            DeltaBuild<double>* build,
            DeltaBed<double>* bed) const {
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      TurnKnob(options_.knobs[k], turned[static_cast<Eigen::Index>(k)], build, bed);
    }
  }

  /// Huber's weight of a residual.
  double Weight(double residual) const {
    const double size = std::abs(residual);
    if (options_.huber_sigma <= 0 || size <= options_.huber_sigma) return 1;
    return options_.huber_sigma / size;
  }

  double Cost(const Rows& rows, const Eigen::VectorXd& turned) const {
    double cost = 0;
    const double far = options_.huber_sigma;
    for (const double residual : rows.residual) {
      const double size = std::abs(residual);
      cost += far <= 0 || size <= far ? size * size : 2 * far * size - far * far;
    }
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      cost += std::pow(
          (turned[static_cast<Eigen::Index>(k)] - believed_[k]) / prior_[k], 2);
    }
    return cost;
  }

  Eigen::VectorXd Weights(const Rows& rows) const {
    return rows.residual.unaryExpr([this](double r) { return Weight(r); });
  }

  Eigen::MatrixXd Normal(const Rows& rows) const {
    Eigen::MatrixXd normal =
        rows.slope.transpose() * Weights(rows).asDiagonal() * rows.slope;
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      normal(at, at) += 1 / (prior_[k] * prior_[k]);
    }
    return normal;
  }

  Eigen::VectorXd Step(const Rows& rows, Eigen::MatrixXd normal, double damping) const {
    Eigen::VectorXd right =
        rows.slope.transpose() * Weights(rows).asDiagonal() * rows.residual;
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      right[at] += (turned_[at] - believed_[k]) / (prior_[k] * prior_[k]);
      normal(at, at) *= 1 + damping;
    }
    // In units of what machines stray by: like numbers, whatever the unit.
    const Eigen::Map<const Eigen::VectorXd> reach(reach_.data(), right.size());
    const Eigen::MatrixXd scaled = reach.asDiagonal() * normal * reach.asDiagonal();
    return -(reach.asDiagonal() *
             PivotedCholesky(scaled).Solve(reach.cwiseProduct(right)));
  }

  void Report(const Rows& rows, DeltaJointFit* fit) const {
    fit->build = drawn_;
    Turn(turned_, &fit->build, &fit->bed);
    const Eigen::Map<const Eigen::VectorXd> reach(
        reach_.data(), static_cast<Eigen::Index>(reach_.size()));
    const Eigen::MatrixXd scaled =
        reach.asDiagonal() * Normal(rows) * reach.asDiagonal();
    const Modes modes = ModesOf(scaled);
    const Eigen::VectorXd variances = modes.values.cwiseMax(1e-300).cwiseInverse();
    fit->covariance = reach.asDiagonal() * modes.vectors * variances.asDiagonal() *
                      modes.vectors.transpose() * reach.asDiagonal();
    const Eigen::VectorXd weakest = modes.vectors.col(0);
    fit->weakest.assign(weakest.begin(), weakest.end());
    fit->weakest_sd = std::sqrt(variances[0]);
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double per_unit =
          kDeltaKnobs[static_cast<std::size_t>(options_.knobs[k])].per_unit;
      const double sd = std::sqrt(fit->covariance(at, at));
      fit->estimates.push_back({.knob = options_.knobs[k],
                                .value = turned_[at] / per_unit,
                                .sd = sd / per_unit,
                                .sd_over_prior = sd / prior_[k]});
    }
    AddBudgets(rows, fit);
    AddErrors(rows, fit);
  }

  void AddBudgets(const Rows& rows, DeltaJointFit* fit) const {
    WeighedFit weighed{
        .slope = rows.slope,
        .weights = Weights(rows),
        .covariance = fit->covariance,
        .prior_sd = prior_,
        .groups = {{"touches", std::ssize(readings_.touches)},
                   {"lengths of a print", std::ssize(readings_.distances)},
                   {"rods by calliper", std::ssize(readings_.rods)}}};
    for (const int knob : options_.knobs) {
      weighed.names.emplace_back(kDeltaKnobs[static_cast<std::size_t>(knob)].name);
    }
    for (std::size_t k = 0; k < prior_.size(); ++k) {
      DeltaEstimate& estimate = fit->estimates[k];
      estimate.budget = BudgetOf(weighed, static_cast<Eigen::Index>(k));
      const double per_unit =
          kDeltaKnobs[static_cast<std::size_t>(estimate.knob)].per_unit;
      for (Contribution& input : estimate.budget) input.u /= per_unit;
    }
  }

  // Leverage h turns a residual into that of a fit without it: r / (1 - h).
  void AddErrors(const Rows& rows, DeltaJointFit* fit) const {
    const Eigen::VectorXd weights = Weights(rows);
    const Eigen::VectorXd leverage =
        (rows.slope * fit->covariance).cwiseProduct(rows.slope).rowwise().sum();
    double square = 0, held_out = 0, chi2 = 0, used = 0;
    const auto num = static_cast<Eigen::Index>(readings_.touches.size());
    for (Eigen::Index i = 0; i < rows.residual.size(); ++i) {
      const double taken = weights[i] * leverage[i];
      chi2 += weights[i] * rows.residual[i] * rows.residual[i];
      used += taken;
      if (i >= num) continue;
      const double sigma_mm = readings_.touches[static_cast<std::size_t>(i)].sigma_mm;
      const double residual_mm = rows.residual[i] * sigma_mm;
      square += residual_mm * residual_mm;
      held_out += std::pow(residual_mm / std::max(1 - taken, 1e-9), 2);
    }
    const double count = static_cast<double>(std::max<Eigen::Index>(num, 1));
    fit->rms_mm = std::sqrt(square / count);
    fit->hold_out_mm = std::sqrt(held_out / count);
    const double dof = static_cast<double>(rows.residual.size()) - used;
    fit->chi2_per_dof = dof > 0.5 ? chi2 / dof : 0;
  }

  const DeltaBuild<double>& drawn_;
  const DeltaReadings& readings_;
  const DeltaJointOptions& options_;
  ReadDelta machine_;
  std::vector<double> prior_{}, believed_{}, reach_{};
  Eigen::VectorXd turned_{};
};

std::vector<int> KnobsOf(const DeltaJointFit& fit) {
  std::vector<int> knobs;
  for (const DeltaEstimate& estimate : fit.estimates) knobs.push_back(estimate.knob);
  return knobs;
}

/// With a sigma of 1 mm heights and slopes come out as they are.
DeltaReadings AskedAt(const std::vector<Vec3<double>>& motors_mm) {
  DeltaReadings asked;
  for (const Vec3<double>& at : motors_mm) {
    asked.touches.push_back({.motors_mm = at, .sigma_mm = 1});
  }
  return asked;
}

/// Heights and their slopes at these motor travels, in mm.
Rows HeightsAt(const DeltaJointFit& fit, const std::vector<Vec3<double>>& motors_mm) {
  const DeltaReadings asked = AskedAt(motors_mm);
  return ReadDelta(asked, KnobsOf(fit)).At(fit.build, fit.bed);
}

}  // namespace

DeltaJointFit FitDeltaJointly(const DeltaBuild<double>& drawn,
                              const DeltaReadings& readings,
                              const DeltaJointOptions& options) {
  return Fitter(drawn, readings, options).Fit();
}

Eigen::MatrixXd HeightSlopes(const DeltaBuild<double>& build,
                             const std::vector<Vec3<double>>& motors_mm,
                             const std::vector<int>& knobs) {
  const DeltaReadings asked = AskedAt(motors_mm);
  return ReadDelta(asked, knobs).At(build, {}).slope;
}

DeltaForetold ForetellHeight(const DeltaJointFit& fit, const Vec3<double>& motors_mm) {
  const Rows rows = HeightsAt(fit, {motors_mm});
  const Eigen::VectorXd slope = rows.slope.row(0).transpose();
  return {rows.residual[0], std::sqrt(slope.dot(fit.covariance * slope))};
}

Vec3<double> BestNextTouch(const DeltaJointFit& fit,
                           const DeltaModel<double>& settings,
                           double radius_mm,
                           double sigma_mm) {
  constexpr int kSteps = 6;
  std::vector<Vec3<double>> points, motors_mm;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j > kSteps * kSteps) continue;
      points.emplace_back(radius_mm * i / kSteps, radius_mm * j / kSteps, 0);
      motors_mm.push_back(DeltaMotors_mm(settings, points.back()));
    }
  }
  const Rows rows = HeightsAt(fit, motors_mm);
  // A touch takes (S C s)^2 / (sigma^2 + s C s) of every point's variance.
  const Eigen::MatrixXd across = rows.slope * fit.covariance * rows.slope.transpose();
  Eigen::Index best = 0;
  double most = -1;
  for (Eigen::Index i = 0; i < across.rows(); ++i) {
    const double taken =
        across.col(i).squaredNorm() / (sigma_mm * sigma_mm + across(i, i));
    if (taken > most) {
      most = taken;
      best = i;
    }
  }
  return points[static_cast<std::size_t>(best)];
}

}  // namespace caltwin
