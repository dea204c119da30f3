#include "sim/machine/disc_overlap.h"

#include <cmath>
#include <vector>

namespace caltwin {
namespace {

constexpr double kWithin_mm = 1e-9;

// Points where the circle crosses the two sides at `at` = face +- half on one axis.
void AddCrossings(const DiscOverFace& f,
                  int axis,
                  std::vector<Eigen::Vector2d>* points) {
  for (const double side : {-1.0, 1.0}) {
    const double at_mm = f.face_mm[axis] + side * f.half_mm[axis];
    const double off_mm = at_mm - f.disc_mm[axis];
    const double square = f.radius_mm * f.radius_mm - off_mm * off_mm;
    if (square < 0) continue;
    for (const double sense : {-1.0, 1.0}) {
      Eigen::Vector2d point;
      point[axis] = at_mm;
      point[1 - axis] = f.disc_mm[1 - axis] + sense * std::sqrt(square);
      points->push_back(point);
    }
  }
}

}  // namespace

Eigen::Vector2d FirstContact_mm(const DiscOverFace& f, const Eigen::Vector2d& uphill) {
  const Eigen::Vector2d low_mm = f.face_mm - f.half_mm;
  const Eigen::Vector2d high_mm = f.face_mm + f.half_mm;
  Eigen::Vector2d best_mm = f.disc_mm.cwiseMax(low_mm).cwiseMin(high_mm);
  if (uphill.norm() == 0) return best_mm;

  // A linear height over a convex region is highest at one of its corners, or where the
  // circle faces uphill.
  std::vector<Eigen::Vector2d> points = {f.disc_mm + f.radius_mm * uphill.normalized(),
                                         low_mm,
                                         high_mm,
                                         {low_mm[0], high_mm[1]},
                                         {high_mm[0], low_mm[1]}};
  AddCrossings(f, 0, &points);
  AddCrossings(f, 1, &points);
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d off_mm = (point - f.face_mm).cwiseAbs() - f.half_mm;
    const bool on_face = off_mm.maxCoeff() <= kWithin_mm;
    const bool on_disc = (point - f.disc_mm).norm() <= f.radius_mm + kWithin_mm;
    if (on_face && on_disc && uphill.dot(point - best_mm) > 0) best_mm = point;
  }
  return best_mm;
}

}  // namespace caltwin
