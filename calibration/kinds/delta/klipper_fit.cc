#include "calibration/kinds/delta/klipper_fit.h"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>

#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

using Jet9 = ceres::Jet<double, kKlipperNine>;
using Parameters = Eigen::Matrix<double, kKlipperNine, 1>;

constexpr int kKlipperFitMostSteps = 60;
constexpr double kSmallStep_mm = 1e-9;

/// Klipper's parameters as lengths, angles as arcs at the start's delta radius, so that
/// all are of one size.
Parameters ParametersOf(const DeltaModel<double>& model, double arc_mm) {
  Parameters p;
  p << model.radius_mm[0], model.endstop_mm[0], model.endstop_mm[1],
      model.endstop_mm[2], model.angle_rad[0] * arc_mm, model.angle_rad[1] * arc_mm,
      model.arm_mm[0], model.arm_mm[1], model.arm_mm[2];
  return p;
}

/// The model of these parameters; the third tower's angle is the reference.
template <typename T>
DeltaModel<T> ModelOf(const Eigen::Matrix<T, kKlipperNine, 1>& p,
                      const DeltaModel<double>& start,
                      double arc_mm) {
  DeltaModel<T> model;
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    model.radius_mm[at] = p[0];
    model.endstop_mm[at] = p[1 + i];
    model.angle_rad[at] = i < 2 ? p[4 + i] / T(arc_mm) : T(start.angle_rad[2]);
    model.arm_mm[at] = p[6 + i];
  }
  return model;
}

template <typename T>
T Distance_mm(const DeltaModel<T>& model, const DeltaDistance& distance) {
  using std::sqrt;
  const Vec3<T> apart = DeltaNozzle_mm<T>(model, distance.to_mm.cast<T>()) -
                        DeltaNozzle_mm<T>(model, distance.from_mm.cast<T>());
  return sqrt(apart.dot(apart));
}

/// Whitened residuals and their slopes by the first parameters.
struct Linearised {
  Eigen::MatrixXd slope{};
  Eigen::VectorXd residual{};
  double cost() const { return residual.squaredNorm(); }
};

class Problem {
 public:
  Problem(std::span<const DeltaTouch> touches,
          std::span<const DeltaDistance> distances,
          const DeltaModel<double>& start,
          int num_parameters)
      : touches_(touches.begin(), touches.end()),
        distances_(distances.begin(), distances.end()),
        start_(start),
        arc_mm_(start.radius_mm[0]),
        num_parameters_(num_parameters) {}

  Parameters start() const { return ParametersOf(start_, arc_mm_); }
  DeltaModel<double> Model(const Parameters& p) const {
    return ModelOf<double>(p, start_, arc_mm_);
  }

  Linearised At(const Parameters& p) const {
    Eigen::Matrix<Jet9, kKlipperNine, 1> jets;
    for (int i = 0; i < kKlipperNine; ++i) jets[i] = Jet9(p[i], i);
    const DeltaModel<Jet9> model = ModelOf<Jet9>(jets, start_, arc_mm_);
    Linearised at;
    const auto rows = static_cast<Eigen::Index>(touches_.size() + distances_.size());
    at.slope.resize(rows, num_parameters_);
    at.residual.resize(rows);
    Eigen::Index row = 0;
    const auto add = [&](const Jet9& residual) {
      at.residual[row] = residual.a;
      at.slope.row(row++) = residual.v.head(num_parameters_).transpose();
    };
    for (const DeltaTouch& touch : touches_) {
      const Jet9 z_mm = DeltaNozzle_mm<Jet9>(model, touch.motors_mm.cast<Jet9>())[2];
      add((z_mm - touch.height_mm) / touch.sigma_mm);
    }
    for (const DeltaDistance& distance : distances_) {
      add((Distance_mm(model, distance) - distance.length_mm) / distance.sigma_mm);
    }
    return at;
  }

 private:
  std::vector<DeltaTouch> touches_;
  std::vector<DeltaDistance> distances_;
  DeltaModel<double> start_;
  double arc_mm_;
  int num_parameters_;
};

/// The least squares step, shortened until it improves; nullopt where none does.
std::optional<Parameters> ImprovedKlipperFit(const Problem& problem,
                                             const Parameters& from,
                                             const Eigen::VectorXd& step,
                                             double cost) {
  constexpr int kMostHalvings = 13;
  double part = 1;
  for (int halving = 0; halving <= kMostHalvings; ++halving, part /= 2) {
    Parameters p = from;
    p.head(step.size()) += part * step;
    const double there = problem.At(p).cost();
    if (std::isfinite(there) && there <= cost) return p;
  }
  return std::nullopt;
}

/// The mean factor by which `truth` moves farther than `believed` commands, around the
/// touches: the nozzle's distance from the middle, by one over by the other.
double ScaleBetween(std::span<const DeltaTouch> touches,
                    const DeltaModel<double>& truth,
                    const DeltaModel<double>& believed) {
  double moved_mm = 0, commanded_mm = 0;
  for (const DeltaTouch& touch : touches) {
    moved_mm += DeltaNozzle_mm(truth, touch.motors_mm).head<2>().norm();
    commanded_mm += DeltaNozzle_mm(believed, touch.motors_mm).head<2>().norm();
  }
  return commanded_mm > 0 ? moved_mm / commanded_mm - 1 : 0;
}

/// Mean square of each touch's height as foretold by a fit of all others.
std::optional<double> HoldOutRms_mm(std::span<const DeltaTouch> touches,
                                    std::span<const DeltaDistance> distances,
                                    const DeltaModel<double>& start,
                                    int num_parameters) {
  const auto readings = static_cast<int>(touches.size() + distances.size());
  if (readings - 1 < num_parameters) return std::nullopt;
  std::vector<double> errors_mm;
  for (std::size_t left_out = 0; left_out < touches.size(); ++left_out) {
    std::vector<DeltaTouch> others(touches.begin(), touches.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    const KlipperFit fit = FitKlipperModel(others, distances, start, num_parameters);
    if (!fit.is_converged || !fit.last_step.identifiable) return std::nullopt;
    errors_mm.push_back(
        HeightResiduals_mm(touches.subspan(left_out, 1), fit.model).front());
  }
  return RootMeanSquare(errors_mm);
}

// The saved numbers are what a fit of their own touches ends at, but for the last
// digits in which Klipper's descent stops: a few tenths of a micrometre in every file
// that we have. What is farther off was changed since, however large the residuals are.
SavedVerdict VerdictOf(const DeltaModel<double>& fit, const DeltaModel<double>& saved) {
  constexpr double kRadius_mm = MmFromUm(5.0), kOther_mm = MmFromUm(10.0);
  double moved_mm = 0;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    moved_mm += (saved.endstop_mm[i] - fit.endstop_mm[i]) / kNumTowers;
  }
  bool is_theirs = std::abs(fit.radius_mm[0] - saved.radius_mm[0]) < kRadius_mm;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const double endstop_mm = saved.endstop_mm[i] - fit.endstop_mm[i] - moved_mm;
    const double arc_mm = (fit.angle_rad[i] - saved.angle_rad[i]) * saved.radius_mm[0];
    const double arm_mm = fit.arm_mm[i] - saved.arm_mm[i];
    for (const double off_mm : {endstop_mm, arc_mm, arm_mm}) {
      is_theirs = is_theirs && std::abs(off_mm) < kOther_mm;
    }
  }
  if (!is_theirs) return SavedVerdict::kStale;
  return std::abs(moved_mm) < kOther_mm ? SavedVerdict::kBelongs
                                        : SavedVerdict::kMovedTogether;
}

}  // namespace

KlipperFit FitKlipperModel(std::span<const DeltaTouch> touches,
                           std::span<const DeltaDistance> distances,
                           const DeltaModel<double>& start,
                           int num_parameters) {
  Require(num_parameters > 0 && num_parameters <= kKlipperNine,
          "Klipper's model has nine parameters");
  const Problem problem(touches, distances, start, num_parameters);
  Parameters p = problem.start();
  KlipperFit fit{.model = start};
  for (int i = 0; i < kKlipperFitMostSteps && !fit.is_converged; ++i) {
    const Linearised at = problem.At(p);
    if (!std::isfinite(at.cost())) break;
    fit.last_step = SolveLinear(at.slope, -at.residual);
    if (fit.last_step.x.size() == 0) break;
    const auto improved = ImprovedKlipperFit(problem, p, fit.last_step.x, at.cost());
    fit.is_converged = !improved || fit.last_step.x.norm() < kSmallStep_mm;
    if (improved) p = *improved;
  }
  fit.model = problem.Model(p);
  fit.residuals_mm = HeightResiduals_mm(touches, fit.model);
  fit.height_rms_mm = RootMeanSquare(fit.residuals_mm);
  std::vector<double> off_mm;
  for (const DeltaDistance& distance : distances) {
    off_mm.push_back(Distance_mm(fit.model, distance) - distance.length_mm);
  }
  fit.distance_rms_mm = RootMeanSquare(off_mm);
  return fit;
}

std::vector<double> HeightResiduals_mm(std::span<const DeltaTouch> touches,
                                       const DeltaModel<double>& model) {
  std::vector<double> residuals_mm;
  residuals_mm.reserve(touches.size());
  for (const DeltaTouch& touch : touches) {
    residuals_mm.push_back(DeltaNozzle_mm(model, touch.motors_mm)[2] - touch.height_mm);
  }
  return residuals_mm;
}

double RootMeanSquare(std::span<const double> values) {
  if (values.empty()) return 0;
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double KlipperDistanceSigma_mm(double touch_sigma_mm,
                               std::size_t num_touches,
                               std::size_t num_distances) {
  constexpr double kMeasureWeight = 0.5;
  if (num_touches == 0) return touch_sigma_mm;
  return touch_sigma_mm *
         std::sqrt(static_cast<double>(num_distances) /
                   (kMeasureWeight * static_cast<double>(num_touches)));
}

std::string Name(SavedVerdict verdict) {
  switch (verdict) {
    case SavedVerdict::kBelongs:
      return "belongs";
    case SavedVerdict::kMovedTogether:
      return "moved";
    case SavedVerdict::kStale:
      return "stale";
  }
  return "";
}

KlipperAssessment AssessKlipper(std::span<const DeltaTouch> touches,
                                std::span<const DeltaDistance> distances,
                                const DeltaModel<double>& saved) {
  const int num_parameters = distances.empty() ? kKlipperSix : kKlipperNine;
  KlipperAssessment assessment;
  const std::vector<double> saved_mm = HeightResiduals_mm(touches, saved);
  assessment.saved_rms_mm = RootMeanSquare(saved_mm);
  for (const double residual_mm : saved_mm) {
    assessment.saved_mean_mm += residual_mm / static_cast<double>(saved_mm.size());
  }
  assessment.fit = FitKlipperModel(touches, distances, saved, num_parameters);
  assessment.spare =
      static_cast<int>(touches.size() + distances.size()) - num_parameters;
  assessment.hold_out_rms_mm =
      HoldOutRms_mm(touches, distances, assessment.fit.model, num_parameters);
  assessment.verdict = VerdictOf(assessment.fit.model, saved);

  constexpr double kLonger_mm = 1;
  DeltaModel<double> longer = assessment.fit.model;
  for (double& arm_mm : longer.arm_mm) arm_mm += kLonger_mm;
  const KlipperFit refit = FitKlipperModel(touches, {}, longer, kKlipperSix);
  assessment.longer_arms_rms_mm = refit.height_rms_mm;
  assessment.longer_arms_radius_mm =
      refit.model.radius_mm[0] - assessment.fit.model.radius_mm[0];
  assessment.longer_arms_scale =
      ScaleBetween(touches, refit.model, assessment.fit.model);
  return assessment;
}

}  // namespace caltwin
