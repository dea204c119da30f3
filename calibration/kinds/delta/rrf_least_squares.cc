#include "calibration/kinds/delta/rrf_least_squares.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr int kRounds = 2;

enum class Factor {
  kEndstopA,
  kEndstopB,
  kEndstopC,
  kRadius,
  kAngleA,
  kAngleB,
  kRods,
  kTiltX,
  kTiltY
};

// What the firmware adjusts. Heights are counted from a bed that leans by the tilts.
struct Belief {
  DeltaModel<double> model{};
  double tilt_x = 0;
  double tilt_y = 0;

  double Height_mm(const Vec3<double>& motors_mm) const {
    const Vec3<double> at = DeltaNozzle_mm(model, motors_mm);
    return at[2] - tilt_x * at[0] - tilt_y * at[1];
  }
};

std::vector<Factor> FactorsOf(int count) {
  using enum Factor;
  std::vector<Factor> all = {kEndstopA, kEndstopB, kEndstopC};
  const auto add = [&all](std::initializer_list<Factor> more) {
    all.insert(all.end(), more);
  };
  if (count >= 4) add({kRadius});
  if (count >= 6) add({kAngleA, kAngleB});
  if (count == 7 || count == 9) add({kRods});
  if (count >= 8) add({kTiltX, kTiltY});
  if (static_cast<int>(all.size()) != count) {
    throw InputError(
        {},
        fmt::format("a delta calibration of {} factors is not known", count),
        "3, 4, 6, 7, 8 and 9 are");
  }
  return all;
}

// A carriage at its endstop stays as high as it is when radius or rods change: the
// nozzle height that goes with the endstop follows.
template <typename Change>
void KeepCarriages(DeltaModel<double>* model, const Change& change) {
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const auto rise_mm = [&] {
      return std::sqrt(model->arm_mm[i] * model->arm_mm[i] -
                       model->radius_mm[i] * model->radius_mm[i]);
    };
    const double before_mm = rise_mm();
    change(i);
    model->endstop_mm[i] += before_mm - rise_mm();
  }
}

// `by` in mm, degrees or (tilts) mm/mm.
void Adjust(Factor factor, double by, Belief* belief) {
  DeltaModel<double>& model = belief->model;
  switch (factor) {
    case Factor::kEndstopA:
    case Factor::kEndstopB:
    case Factor::kEndstopC:
      model.endstop_mm[static_cast<std::size_t>(factor)] += by;
      return;
    case Factor::kRadius:
      KeepCarriages(&model, [&](std::size_t i) { model.radius_mm[i] += by; });
      return;
    case Factor::kAngleA:
      model.angle_rad[0] += RadFromDeg(by);
      return;
    case Factor::kAngleB:
      model.angle_rad[1] += RadFromDeg(by);
      return;
    case Factor::kRods:
      KeepCarriages(&model, [&](std::size_t i) { model.arm_mm[i] += by; });
      return;
    case Factor::kTiltX:
      belief->tilt_x += by;
      return;
    case Factor::kTiltY:
      belief->tilt_y += by;
      return;
  }
}

double Slope(const Belief& belief, Factor factor, const Vec3<double>& motors_mm) {
  constexpr double kStep = 0.2;
  Belief high = belief, low = belief;
  Adjust(factor, kStep, &high);
  Adjust(factor, -kStep, &low);
  return (high.Height_mm(motors_mm) - low.Height_mm(motors_mm)) / (2 * kStep);
}

double Deviation_mm(std::span<const DeltaTouch> touches, const Belief& belief) {
  double square = 0;
  for (const DeltaTouch& touch : touches) {
    square += std::pow(belief.Height_mm(touch.motors_mm) - touch.height_mm, 2);
  }
  return std::sqrt(square / static_cast<double>(touches.size()));
}

// One Gauss-Newton round; nullopt where the factors cannot be told apart.
std::optional<Belief> ImprovedRrfLeastSquares(std::span<const DeltaTouch> touches,
                                              const std::vector<Factor>& factors,
                                              const Belief& belief) {
  const auto num = static_cast<Eigen::Index>(factors.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num, num);
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(num);
  Eigen::VectorXd row(num);
  for (const DeltaTouch& touch : touches) {
    for (Eigen::Index i = 0; i < num; ++i) {
      row[i] = Slope(belief, factors[static_cast<std::size_t>(i)], touch.motors_mm);
    }
    normal += row * row.transpose();
    wanted -= row * (belief.Height_mm(touch.motors_mm) - touch.height_mm);
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> solver(normal);
  if (!solver.isInvertible()) return std::nullopt;
  const Eigen::VectorXd by = solver.solve(wanted);
  Belief improved = belief;
  for (Eigen::Index i = 0; i < num; ++i) {
    Adjust(factors[static_cast<std::size_t>(i)], by[i], &improved);
  }
  return improved;
}

}  // namespace

std::vector<Eigen::Vector2d> RrfProbePoints(double radius_mm) {
  std::vector<Eigen::Vector2d> points;
  const auto add = [&](double at_radius_mm, double angle_rad) {
    points.emplace_back(at_radius_mm * std::cos(angle_rad),
                        at_radius_mm * std::sin(angle_rad));
  };
  for (int i = 0; i < 8; ++i) add(radius_mm, RadFromDeg(45.0 * i));
  for (int i = 0; i < 6; ++i) add(radius_mm / 2, RadFromDeg(15.0 + 60 * i));
  points.emplace_back(0, 0);
  points.emplace_back(0.2 * radius_mm, 0.35 * radius_mm);
  return points;
}

DeltaOutcome FitRrf(std::span<const DeltaTouch> touches,
                    const DeltaModel<double>& start,
                    int factors) {
  const std::vector<Factor> all = FactorsOf(factors);
  Require(touches.size() >= all.size(), "as many touches as factors");
  DeltaOutcome outcome{.settings = start, .touches = static_cast<int>(touches.size())};
  Belief belief{.model = start};
  const double before_mm = Deviation_mm(touches, belief);
  for (int round = 0; round < kRounds; ++round) {
    const auto improved = ImprovedRrfLeastSquares(touches, all, belief);
    if (!improved) {
      outcome.said_mm = before_mm;
      outcome.messages.emplace_back(
          "Unable to calculate calibration parameters. Please choose different probe "
          "points.");
      return outcome;
    }
    belief = *improved;
  }
  const double after_mm = Deviation_mm(touches, belief);
  outcome.settings = belief.model;
  outcome.tilt_x = belief.tilt_x;
  outcome.tilt_y = belief.tilt_y;
  outcome.said_mm = after_mm;
  outcome.is_done = std::isfinite(after_mm);
  outcome.messages.push_back(fmt::format(
      "Calibrated {} factors using {} points, deviation before {:.3f} after "
      "{:.3f}",
      factors,
      touches.size(),
      before_mm,
      after_mm));
  return outcome;
}

DeltaOutcome CalibrateRrf(const DeltaProbe& probe,
                          const DeltaModel<double>& start,
                          const RrfOptions& options) {
  std::vector<DeltaTouch> touches;
  for (const Eigen::Vector2d& point : options.points) {
    const auto motors_mm = probe(start, point[0], point[1]);
    if (!motors_mm) {
      return {
          .settings = start,
          .touches = static_cast<int>(touches.size()),
          .messages = {fmt::format("Auto calibration failed because probe point P{} "
                                   "was unreachable",
                                   touches.size())}};
    }
    touches.push_back({.motors_mm = *motors_mm});
  }
  return FitRrf(touches, start, options.factors);
}

}  // namespace caltwin
