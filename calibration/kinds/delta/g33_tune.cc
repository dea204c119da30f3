#include "calibration/kinds/delta/g33_tune.h"

#include <cmath>

#include <Eigen/LU>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kStep = 0.01;  // mm or deg.
constexpr int kNumPoints = 7;

// Of the i-th point of the circle (1 to 6): 210 deg is tower a's.
double PointAngle_rad(int point) {
  return RadFromDeg(210 + 60.0 * (point - 1));
}

// How the seven points rise, against the centre, when the settings become `changed`
// while the carriages stay.
G33Heights Rise_mm(const DeltaModel<double>& settings,
                   const DeltaModel<double>& changed,
                   double at_mm) {
  G33Heights rise =
      G33Forward(G33Carriages_mm(settings, at_mm) - G33Carriages_mm(changed, at_mm),
                 at_mm,
                 settings.radius_mm[0]);
  rise.array() -= double{rise[0]};
  return rise;
}

}  // namespace

G33Heights G33Forward(const Eigen::Matrix<double, 3, 7>& carriages_mm,
                      double at_mm,
                      double radius_mm) {
  G33Heights heights_mm;
  for (int point = 0; point < kNumPoints; ++point) {
    const double q = point == 0 ? 0 : at_mm / radius_mm;
    heights_mm[point] = 0;
    for (int tower = 0; tower < kNumTowers; ++tower) {
      const double towards =
          std::cos(PointAngle_rad(point) - PointAngle_rad(1 + 2 * tower));
      heights_mm[point] += (1 + 2 * q * towards) / 3 * carriages_mm(tower, point);
    }
  }
  return heights_mm;
}

Eigen::Matrix<double, 3, 7> G33Carriages_mm(const DeltaModel<double>& settings,
                                            double at_mm) {
  Eigen::Matrix<double, 3, 7> carriages_mm;
  for (int point = 0; point < kNumPoints; ++point) {
    const double radius_mm = point == 0 ? 0 : at_mm;
    const double x_mm = radius_mm * std::cos(PointAngle_rad(point));
    const double y_mm = radius_mm * std::sin(PointAngle_rad(point));
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      const double dx_mm =
          settings.radius_mm[i] * std::cos(settings.angle_rad[i]) - x_mm;
      const double dy_mm =
          settings.radius_mm[i] * std::sin(settings.angle_rad[i]) - y_mm;
      carriages_mm(static_cast<int>(i), point) = std::sqrt(
          settings.arm_mm[i] * settings.arm_mm[i] - dx_mm * dx_mm - dy_mm * dy_mm);
    }
  }
  return carriages_mm;
}

double G33TuneH(const DeltaModel<double>& settings, double at_mm) {
  return 2.0 / 3 / (at_mm / settings.radius_mm[0]);
}

double G33TuneR(const DeltaModel<double>& settings, double at_mm) {
  DeltaModel<double> changed = settings;
  for (double& radius_mm : changed.radius_mm) radius_mm += kStep;
  const double fall_mm = -Rise_mm(settings, changed, at_mm).tail<6>().mean();
  return kStep / fall_mm / 3;
}

double G33TuneA(const DeltaModel<double>& settings, double at_mm) {
  double rise_mm = 0;
  for (int tower = 0; tower < kNumTowers; ++tower) {
    DeltaModel<double> changed = settings;
    changed.angle_rad[static_cast<std::size_t>(tower)] += RadFromDeg(kStep);
    const G33Heights rise = Rise_mm(settings, changed, at_mm);
    const int clockwise = (2 * tower + 5) % 6 + 1, counter = 2 * tower + 2;
    rise_mm += (rise[clockwise] - rise[counter]) / 6;
  }
  return kStep / rise_mm / 3;
}

G33Factors G33Tuned(const DeltaModel<double>& settings, double at_mm) {
  return {.h = G33TuneH(settings, at_mm),
          .r = G33TuneR(settings, at_mm),
          .a = G33TuneA(settings, at_mm)};
}

Eigen::Matrix3d G33AngleInverse(G33Variant variant, double x) {
  Eigen::Matrix3d displacement;
  displacement << 0, 1, -1, -1, 0, 1, 1, -1, 0;
  const Eigen::Matrix3d filled = displacement + Eigen::Matrix3d::Constant(x);
  const double taken = variant == G33Variant::kAsPublished ? 1 / x : 1 / (9 * x);
  return filled.inverse() - Eigen::Matrix3d::Constant(taken);
}

G33Matrix G33Correction(const G33Case& what,
                        const G33Factors& factors,
                        G33Variant variant) {
  // x: small enough to vanish, large enough to leave the rest its digits.
  constexpr double kAdded = 1e-4;
  G33Matrix matrix = G33Matrix::Zero();
  if (what.points == 0) return matrix;
  matrix.col(0).head<3>().setOnes();
  if (what.points == 1) return matrix;
  // Columns of the tower, and of the point opposite, of each tower.
  constexpr int kTower[] = {1, 3, 5}, kOpposite[] = {4, 6, 2};
  const bool is_full = what.points >= 3;
  const bool use_towers = is_full || what.tower_angles;
  const bool use_opposite = is_full || !what.tower_angles;
  const double share = is_full ? 0.5 : 1;
  for (int i = 0; i < kNumTowers; ++i) {
    for (int k = 0; k < kNumTowers; ++k) {
      const double h = share * (i == k ? 1 : -0.5) * factors.h;
      if (use_towers) matrix(i, kTower[k]) = h;
      if (use_opposite) matrix(i, kOpposite[k]) = -h;
    }
    if (use_towers) matrix(3, kTower[i]) = share * factors.r;
    if (use_opposite) matrix(3, kOpposite[i]) = share * factors.r;
  }
  matrix(3, 0) = -3 * factors.r;
  if (!is_full || !what.tower_angles) return matrix;
  const Eigen::Matrix3d inverse = 3 * factors.a * G33AngleInverse(variant, kAdded);
  for (int k = 0; k < kNumTowers; ++k) {
    matrix.col(kTower[k]).tail<3>() = inverse.col(k);
    matrix.col(kOpposite[k]).tail<3>() = inverse.col(k);
  }
  return matrix;
}

}  // namespace caltwin
