#include "calibration/diagnosis/periodogram.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/Core>
#include <Eigen/LU>

#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/covariate.h"
#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/nuisances.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::size_t kLeastPositions = 8;
constexpr double kLinesPerSpan = 4;    // Frequencies a resolvable line.
constexpr double kMostHarmonic = 4.5;  // Of one turn.
constexpr double kMostLines = 3000;
constexpr double kLinesAboutStep = 6;
constexpr double kChance = 0.01;

struct Wave {
  double before_mm = std::numeric_limits<double>::quiet_NaN();
  double after_mm = std::numeric_limits<double>::quiet_NaN();
  double variance_mm2 = 0;  // Of its sine and cosine parts, the mean; 0: not told.
};

class Waves {
 public:
  Waves(const Observed& observed, const Diagnosis& diagnosis, Axis axis)
      : observed_(AtBaseline(observed)),
        axis_(axis),
        shows_(ChannelOf(observed_, Name(axis))),
        evidence_(
            observed_, {diagnosis.sigma_mm, 0}, BaselineAndBend(), LeftOut(diagnosis)),
        before_(evidence_.Whiten(diagnosis.residual_before_mm)),
        after_(evidence_.Whiten(diagnosis.residual_after_mm)) {}

  // Positions at which motion along the axis was read.
  std::set<long> Positions_um() const {
    std::set<long> positions;
    for (Eigen::Index i = 0; i < shows_.size(); ++i) {
      if (IsAlong(i)) positions.insert(std::lround(UmFromMm(Q_mm(i))));
    }
    return positions;
  }

  Wave At(double per_mm) const {
    constexpr double kLeastVisible = 0.15;
    Eigen::MatrixXd columns(shows_.size(), 2);
    for (Eigen::Index i = 0; i < shows_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * per_mm * Q_mm(i);
      columns(i, 0) = shows_[i] * std::sin(angle);
      columns(i, 1) = shows_[i] * std::cos(angle);
    }
    const Eigen::MatrixXd white = evidence_.Whiten(columns);
    const Eigen::MatrixXd left = evidence_.Left(white);
    const Eigen::Matrix2d gram = left.transpose() * left;
    const double whole = white.squaredNorm() / 2;
    const double mean = gram.trace() / 2;
    const double spread = std::hypot((gram(0, 0) - gram(1, 1)) / 2, gram(0, 1));
    Wave wave;
    if (mean - spread < kLeastVisible * whole) return wave;
    const Eigen::Matrix2d inverse = gram.inverse();
    wave.before_mm = (inverse * (left.transpose() * before_)).norm();
    wave.after_mm = (inverse * (left.transpose() * after_)).norm();
    wave.variance_mm2 = inverse.trace() / 2;
    return wave;
  }

 private:
  static constexpr double kAlong = 0.5;

  std::vector<bool> LeftOut(const Diagnosis& diagnosis) const {
    std::vector<bool> out;
    for (Eigen::Index i = 0; i < observed_.num_rows(); ++i) {
      out.push_back(std::ranges::find(diagnosis.outlier_rows, observed_.row(i).row) !=
                    diagnosis.outlier_rows.end());
    }
    return out;
  }
  // A bend would leak into every wave.
  std::vector<Nuisance> BaselineAndBend() const {
    constexpr double kFree = 1e3;  // In units of 1 mm at the ends.
    std::vector<Nuisance> all = BaselineOf(observed_);
    const auto along = CovariateOf(observed_, Name(axis_));
    if (!along) return all;
    for (const int power : {2, 3}) {
      Nuisance bend{.column_mm = shows_, .prior_sd = kFree, .reported = false};
      for (Eigen::Index i = 0; i < shows_.size(); ++i) {
        bend.column_mm[i] *= std::pow(along->Scaled(along->values[i]), power);
      }
      all.push_back(std::move(bend));
    }
    return all;
  }
  bool IsAlong(Eigen::Index i) const { return std::abs(shows_[i]) > kAlong; }
  double Q_mm(Eigen::Index i) const { return observed_.at(i).q_mm[Index(axis_)]; }

  Observed observed_;
  Axis axis_;
  Eigen::VectorXd shows_;
  Evidence evidence_;
  Eigen::VectorXd before_, after_;
};

// Frequencies in 1/mm, ascending: from two waves over the span to the harmonics of a
// turn, then those about four full steps.
std::vector<double> Frequencies_per_mm(double span_mm, const Periodogram& shape) {
  const double last = kMostHarmonic / shape.lead_mm;
  const double step = std::max(1 / (kLinesPerSpan * span_mm), last / kMostLines);
  std::vector<double> all;
  if (2 / span_mm > last) return all;
  const auto add = [&all](double from, double to, double by) {
    const auto count = static_cast<int>(std::floor((to - from) / by + 1e-9));
    for (int i = 0; i <= count; ++i) all.push_back(from + i * by);
  };
  add(2 / span_mm, last, step);
  const double of_steps = 1 / shape.four_full_steps_mm;
  const double about = kLinesAboutStep / span_mm;
  add(std::max(last + step, of_steps - about),
      of_steps + about,
      1 / (kLinesPerSpan * span_mm));
  return all;
}

}  // namespace

std::optional<Periodogram> PeriodogramOf(const Observed& observed,
                                         const Diagnosis& diagnosis,
                                         Axis axis) {
  const Waves waves(observed, diagnosis, axis);
  const std::set<long> positions_um = waves.Positions_um();
  if (positions_um.size() < kLeastPositions) return std::nullopt;
  const double span_mm =
      MmFromUm(static_cast<double>(*positions_um.rbegin() - *positions_um.begin()));
  const AxisDrawing& drawing = observed.machine().axis(axis);
  if (drawing.lead_mm <= 0 || drawing.full_steps_per_rev <= 0) return std::nullopt;
  Periodogram shape{
      .axis = std::string(Name(axis)),
      .lead_mm = drawing.lead_mm,
      .is_belt = drawing.is_belt,
      .four_full_steps_mm = 4 * drawing.lead_mm / drawing.full_steps_per_rev};
  std::vector<double> variances_mm2;
  for (const double f : Frequencies_per_mm(span_mm, shape)) {
    const Wave wave = waves.At(f);
    shape.period_mm.push_back(1 / f);
    shape.before_um.push_back(UmFromMm(wave.before_mm));
    shape.after_um.push_back(UmFromMm(wave.after_mm));
    if (wave.variance_mm2 > 0) variances_mm2.push_back(wave.variance_mm2);
  }
  if (variances_mm2.empty()) return std::nullopt;
  // Both parts normal with the same variance v: P(amplitude > A) = exp(-A^2 / 2v).
  std::ranges::sort(variances_mm2);
  const double variance_mm2 = variances_mm2[variances_mm2.size() / 2];
  const double lines =
      std::max(1.0, static_cast<double>(variances_mm2.size()) / kLinesPerSpan);
  shape.noise_um = UmFromMm(std::sqrt(2 * variance_mm2 * std::log(lines / kChance)));
  return shape;
}

double PeakPeriod_mm(const Periodogram& periodogram) {
  double best_um = 0, period_mm = 0;
  for (std::size_t i = 0; i < periodogram.period_mm.size(); ++i) {
    if (periodogram.before_um[i] > best_um) {
      best_um = periodogram.before_um[i];
      period_mm = periodogram.period_mm[i];
    }
  }
  return period_mm;
}

std::size_t NumOfTurns(const Periodogram& periodogram) {
  const double shortest_mm = periodogram.lead_mm / (kMostHarmonic * 1.001);
  const auto first = std::ranges::find_if(periodogram.period_mm,
                                          [&](double mm) { return mm < shortest_mm; });
  return static_cast<std::size_t>(first - periodogram.period_mm.begin());
}

}  // namespace caltwin
