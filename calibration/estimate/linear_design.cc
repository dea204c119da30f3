#include "calibration/estimate/linear_design.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "calibration/estimate/joint_model.h"
#include "sim/base/dense.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kRelaxed = 1e3;  // As FitJoint does to see what readings know.
constexpr double kNotLearned = 0.9;
constexpr double kIndispensable = 1e-9;  // What a reading's own noise leaves of it.
// Of a nuisance that nothing tells: a guess of a metre (or its scale a thousandfold)
// rather than none.
constexpr double kWideGuess = 1e3;

// 1 / sd^2 of what is known of each unknown before any reading, in its scale; beliefs
// divided by `relaxed`.
Eigen::VectorXd KnownBefore(const JointModel& model, double relaxed) {
  Eigen::VectorXd information(model.size());
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    const auto add = [&](const Given& given, double widened) {
      if (!std::isfinite(given.sd)) return;
      const double sd = std::max(given.sd / unknown.scale, 1e-6) * widened;
      information[i] += 1 / (sd * sd);
    };
    information[i] = 1 / (kWideGuess * kWideGuess);
    add(unknown.prior, relaxed);
    add(unknown.measured, 1);
  }
  return information;
}

Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& information) {
  return PivotedCholesky(information).Inverse();
}

Eigen::MatrixXd JacobianOf(const JointModel& model) {
  Eigen::MatrixXd gradient;
  model.Residuals(Eigen::VectorXd::Zero(model.size()), &gradient);
  return -gradient;  // Of readings, by unknowns, whitened.
}

// The covariance while readings are added, free parameters first.
class Growing {
 public:
  explicit Growing(const JointProblem& problem)
      : model_(problem),
        jacobian_(JacobianOf(model_)),
        count_(static_cast<Eigen::Index>(problem.free.size())),
        covariance_(KnownBefore(model_, 1).cwiseInverse().asDiagonal()),
        before_(covariance_.diagonal().head(count_)) {}

  Eigen::Index num_readings() const { return jacobian_.rows(); }
  double RelativeSd() const {
    const Eigen::VectorXd now = covariance_.diagonal().head(count_);
    return std::sqrt(now.cwiseQuotient(before_).mean());
  }
  // How much better it is known with that reading, by the criterion.
  double Gain(Eigen::Index reading, Optimal optimal) const {
    const Eigen::VectorXd moved = covariance_ * jacobian_.row(reading).transpose();
    const double widened = 1 + jacobian_.row(reading).dot(moved);
    const Eigen::VectorXd of_free = moved.head(count_);
    if (optimal == Optimal::kA) {
      return of_free.cwiseAbs2().cwiseQuotient(before_).sum() / widened;
    }
    const Eigen::MatrixXd free = covariance_.topLeftCorner(count_, count_);
    return of_free.dot(PivotedCholesky(free).Solve(of_free)) / widened;
  }
  NextReading Best(Optimal optimal) const {
    NextReading best;
    double most = -1;
    for (Eigen::Index i = 0; i < num_readings(); ++i) {
      // Of equal ones the first, whatever rounding says.
      const double gain = Gain(i, optimal);
      if (gain <= most * (1 + 1e-9)) continue;
      most = gain;
      best.reading = static_cast<std::size_t>(i);
    }
    return best;
  }
  // Variances of the free parameters without that reading; infinite where nothing else
  // tells what it does.
  Eigen::VectorXd VariancesWithout(std::size_t reading) const {
    const auto row = jacobian_.row(static_cast<Eigen::Index>(reading));
    const Eigen::VectorXd moved = covariance_ * row.transpose();
    const double narrowed = 1 - row.dot(moved);
    if (narrowed < kIndispensable) {
      return Eigen::VectorXd::Constant(count_, std::numeric_limits<double>::infinity());
    }
    return Variances() + moved.head(count_).cwiseAbs2() / narrowed;
  }
  Eigen::VectorXd Variances() const { return covariance_.diagonal().head(count_); }
  void LeaveOut(std::size_t reading) {
    const auto row = jacobian_.row(static_cast<Eigen::Index>(reading));
    const Eigen::VectorXd moved = covariance_ * row.transpose();
    covariance_ += moved * moved.transpose() / (1 - row.dot(moved));
  }
  void Add(std::size_t reading) {
    const auto row = jacobian_.row(static_cast<Eigen::Index>(reading));
    const Eigen::VectorXd moved = covariance_ * row.transpose();
    covariance_ -= moved * moved.transpose() / (1 + row.dot(moved));
  }

 private:
  JointModel model_;
  Eigen::MatrixXd jacobian_;
  Eigen::Index count_;
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd before_;
};

Growing WithAll(const JointProblem& problem) {
  Growing growing(problem);
  for (Eigen::Index i = 0; i < growing.num_readings(); ++i) {
    growing.Add(static_cast<std::size_t>(i));
  }
  return growing;
}

}  // namespace

NextReading BestAfterAll(const JointProblem& problem, Optimal optimal) {
  Growing growing = WithAll(problem);
  NextReading best = growing.Best(optimal);
  growing.Add(best.reading);
  best.relative_sd = growing.RelativeSd();
  return best;
}

double RelativeSdOfAll(const JointProblem& problem) {
  return WithAll(problem).RelativeSd();
}

namespace {

// Which of the design's unknowns all readings tell.
std::vector<Eigen::Index> ToldBy(const LinearDesign& design) {
  std::vector<Eigen::Index> told;
  for (std::size_t i = 0; i < design.unknowns.size(); ++i) {
    if (design.unknowns[i].identifiable) told.push_back(static_cast<Eigen::Index>(i));
  }
  return told;
}

// The reading without which every growth of variance is within `most`, and their sum
// least; none where there is none.
std::optional<std::size_t> LeastMissed(const Growing& growing,
                                       const std::vector<std::size_t>& left,
                                       const Eigen::VectorXd& all,
                                       const std::vector<Eigen::Index>& told,
                                       double most) {
  std::optional<std::size_t> least;
  double least_sum = std::numeric_limits<double>::infinity();
  for (const std::size_t reading : left) {
    const Eigen::VectorXd growth =
        growing.VariancesWithout(reading).cwiseQuotient(all)(told);
    if (!(growth.maxCoeff() <= most)) continue;
    // Of equal ones the first, whatever rounding says.
    if (growth.sum() >= least_sum * (1 - 1e-9)) continue;
    least_sum = growth.sum();
    least = reading;
  }
  return least;
}

}  // namespace

EnoughReadings EnoughOf(const JointProblem& problem, double most) {
  Growing growing = WithAll(problem);
  const LinearDesign design = DesignOf(problem);
  const std::vector<Eigen::Index> told = ToldBy(design);
  const Eigen::VectorXd all = growing.Variances();
  EnoughReadings enough{.num_told = static_cast<int>(told.size())};
  for (Eigen::Index i = 0; i < growing.num_readings(); ++i) {
    enough.readings.push_back(static_cast<std::size_t>(i));
  }
  if (told.empty()) return enough;
  const double limit = most * most * (1 + 1e-9);
  while (const auto least = LeastMissed(growing, enough.readings, all, told, limit)) {
    growing.LeaveOut(*least);
    std::erase(enough.readings, *least);
  }
  const Eigen::VectorXd growth = growing.Variances().cwiseQuotient(all)(told);
  Eigen::Index worst = 0;
  enough.largest_ratio = std::sqrt(growth.maxCoeff(&worst));
  enough.worst =
      design.unknowns[static_cast<std::size_t>(told[static_cast<std::size_t>(worst)])]
          .name;
  return enough;
}

LinearDesign DesignOf(const JointProblem& problem) {
  const JointModel model(problem);
  const Eigen::MatrixXd jacobian = JacobianOf(model);
  const Eigen::MatrixXd readings = jacobian.transpose() * jacobian;
  const auto with = [&](double relaxed) {
    Eigen::MatrixXd information = readings;
    information.diagonal() += KnownBefore(model, relaxed);
    return CovarianceOf(information);
  };
  const Eigen::MatrixXd covariance = with(1), alone = with(kRelaxed);
  const auto count = static_cast<Eigen::Index>(problem.free.size());
  Eigen::VectorXd scale(count);
  LinearDesign design;
  for (Eigen::Index i = 0; i < count; ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    Require(std::isfinite(unknown.prior.sd), "a linear design's unknown has a prior");
    scale[i] = unknown.scale;
    const double readings_sd = std::sqrt(alone(i, i)) * unknown.scale;
    design.unknowns.push_back(
        {.name = unknown.name,
         .unit = unknown.unit,
         .middle = unknown.prior.value,
         .sd = std::sqrt(covariance(i, i)) * unknown.scale,
         .readings_sd = readings_sd,
         .identifiable = readings_sd < kNotLearned * unknown.prior.sd});
  }
  const Eigen::MatrixXd gain = covariance.topRows(count) * jacobian.transpose();
  design.gain = scale.asDiagonal() * gain;
  design.bias =
      scale.asDiagonal() *
      (gain * jacobian.leftCols(count) - Eigen::MatrixXd::Identity(count, count)) *
      scale.cwiseInverse().asDiagonal();
  return design;
}

}  // namespace caltwin
