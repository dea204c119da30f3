#include "calibration/kinds/delta/klipper_descent.h"

#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr std::size_t kNumHeightParameters = 6;
constexpr std::size_t kNumParameters = 9;

Eigen::Vector2d Polar(double radius_mm, double angle_deg) {
  const double angle_rad = RadFromDeg(angle_deg);
  return {radius_mm * std::cos(angle_rad), radius_mm * std::sin(angle_rad)};
}

// Changes of: radius [mm], angles a and b [deg], endstops [mm], arms [mm].
using Changes = std::array<double, kNumParameters>;

DeltaModel<double> Changed(const DeltaModel<double>& start, const Changes& by) {
  DeltaModel<double> model = start;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    model.radius_mm[i] += by[0];
    model.endstop_mm[i] += by[3 + i];
    model.arm_mm[i] += by[6 + i];
  }
  model.angle_rad[0] += RadFromDeg(by[1]);
  model.angle_rad[1] += RadFromDeg(by[2]);
  return model;
}

struct Data {
  std::span<const DeltaTouch> touches{};
  std::span<const DeltaDistance> distances{};
  double height_weight = 1;

  double HeightSquares_mm2(const DeltaModel<double>& model) const {
    double square = 0;
    for (const DeltaTouch& touch : touches) {
      const double off_mm = DeltaNozzle_mm(model, touch.motors_mm)[2] - touch.height_mm;
      square += off_mm * off_mm;
    }
    return square;
  }

  double Error_mm2(const DeltaModel<double>& model) const {
    double error = HeightSquares_mm2(model) * height_weight;
    for (const DeltaDistance& distance : distances) {
      const Vec3<double> from = DeltaNozzle_mm(model, distance.from_mm);
      const Vec3<double> to = DeltaNozzle_mm(model, distance.to_mm);
      const double off_mm = (to - from).norm() - distance.length_mm;
      error += off_mm * off_mm;
    }
    return error;
  }
};

// One parameter's turn: its new value, and whether the error fell.
bool Step(const DeltaModel<double>& start,
          const Data& data,
          double step,
          double* parameter,
          const Changes& all,
          double* best_mm2) {
  const double before = *parameter;
  for (const double to : {before + step, before - step}) {
    *parameter = to;
    const double error_mm2 = data.Error_mm2(Changed(start, all));
    if (error_mm2 < *best_mm2) {
      *best_mm2 = error_mm2;
      return true;
    }
  }
  *parameter = before;
  return false;
}

DeltaModel<double> Descend(const DeltaModel<double>& start, const Data& data) {
  constexpr double kSmallest = 1e-5;
  constexpr int kMostRounds = 10000;
  const std::size_t num =
      data.distances.empty() ? kNumHeightParameters : kNumParameters;
  Changes by{}, step{};
  std::fill_n(step.begin(), num, 1.0);
  double best_mm2 = data.Error_mm2(start);
  for (int round = 0; round < kMostRounds; ++round) {
    double sum = 0;
    for (std::size_t i = 0; i < num; ++i) sum += step[i];
    if (sum <= kSmallest) break;
    for (std::size_t i = 0; i < num; ++i) {
      const bool is_better = Step(start, data, step[i], &by[i], by, &best_mm2);
      step[i] *= is_better ? 1.1 : 0.9;
    }
  }
  return Changed(start, by);
}

std::vector<std::string> ConfigLines(const DeltaModel<double>& model) {
  std::vector<std::string> lines;
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    lines.push_back(fmt::format(
        "stepper_{}: position_endstop: {:.6f} angle: {:.6f} arm_length: {:.6f}",
        TowerName(i),
        model.endstop_mm[at],
        DegFromRad(model.angle_rad[at]),
        model.arm_mm[at]));
  }
  lines.push_back(fmt::format("delta_radius: {:.6f}", model.radius_mm[0]));
  return lines;
}

}  // namespace

std::vector<Eigen::Vector2d> KlipperProbePoints(double radius_mm) {
  constexpr std::array kShare = {0.95, 0.90, 0.85, 0.70, 0.75, 0.80};
  std::vector<Eigen::Vector2d> points = {{0, 0}};
  for (std::size_t i = 0; i < kShare.size(); ++i) {
    points.push_back(Polar(radius_mm * kShare[i], 90 + 60.0 * static_cast<double>(i)));
  }
  return points;
}

std::vector<KlipperRidge> KlipperPrint() {
  constexpr double kPillar_mm = 65, kHalfRidge_mm = 4.5;
  std::vector<KlipperRidge> print;
  for (int i = 0; i < 6; ++i) {
    const double angle_deg = 210 + 60.0 * i;
    print.push_back({Polar(kHalfRidge_mm, angle_deg),
                     Polar(kPillar_mm + kHalfRidge_mm, angle_deg)});
  }
  // From pillar to pillar around the rim: 120 deg on from the spoke's own direction.
  for (int i = 0; i < 6; ++i) {
    const double angle_deg = 210 + 60.0 * i;
    const Eigen::Vector2d pillar = Polar(kPillar_mm, angle_deg);
    print.push_back({pillar + Polar(kHalfRidge_mm, angle_deg + 120),
                     pillar + Polar(kPillar_mm + kHalfRidge_mm, angle_deg + 120)});
  }
  return print;
}

DeltaOutcome FitKlipper(std::span<const DeltaTouch> touches,
                        std::span<const DeltaDistance> distances,
                        const DeltaModel<double>& start) {
  Require(!touches.empty(), "heights to fit");
  constexpr double kDistanceWeight = 0.5;
  Data data{.touches = touches, .distances = distances};
  const auto num = static_cast<double>(touches.size());
  if (!distances.empty()) {
    data.height_weight =
        static_cast<double>(distances.size()) / (kDistanceWeight * num);
  }
  const DeltaModel<double> found = Descend(start, data);
  return {.settings = found,
          .touches = static_cast<int>(touches.size()),
          .is_done = true,
          .said_mm = std::sqrt(data.HeightSquares_mm2(found) / num),
          .messages = ConfigLines(found)};
}

DeltaOutcome CalibrateKlipper(const DeltaProbe& probe,
                              const DeltaModel<double>& start,
                              const KlipperOptions& options) {
  std::vector<DeltaTouch> touches;
  for (const Eigen::Vector2d& point : options.points) {
    const auto motors_mm = probe(start, point[0], point[1]);
    if (!motors_mm) {
      return {.settings = start,
              .touches = static_cast<int>(touches.size()),
              .messages = {"Probe point out of reach"}};
    }
    touches.push_back({.motors_mm = *motors_mm});
  }
  return FitKlipper(touches, options.distances, start);
}

}  // namespace caltwin
