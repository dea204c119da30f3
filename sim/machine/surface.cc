#include "sim/machine/surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kRingWall_mm = 15;
constexpr double kPocketWall_mm = 15;
constexpr double kLipHeight_mm = 30;  // Underside of the ledge's lip above its base.
constexpr double kPillarDepth_mm = 10;

// Signed distance to a box at the origin, with the gradient.
template <int kDim>
double BoxDistance(const Eigen::Matrix<double, kDim, 1>& p,
                   const Eigen::Matrix<double, kDim, 1>& half,
                   Eigen::Matrix<double, kDim, 1>* gradient) {
  const Eigen::Matrix<double, kDim, 1> beyond = p.cwiseAbs() - half;
  gradient->setZero();
  if (beyond.maxCoeff() <= 0) {
    Eigen::Index face = 0;
    const double depth = beyond.maxCoeff(&face);
    (*gradient)[face] = p[face] < 0 ? -1 : 1;
    return depth;
  }
  const Eigen::Matrix<double, kDim, 1> outside = beyond.cwiseMax(0);
  const double distance = outside.norm();
  for (int i = 0; i < kDim; ++i) {
    (*gradient)[i] = (p[i] < 0 ? -1 : 1) * outside[i] / distance;
  }
  return distance;
}

}  // namespace

Solid TableOf(const Machine& machine) {
  const AxisDrawing& x = machine.axis(Axis::kX);
  const AxisDrawing& y = machine.axis(Axis::kY);
  return {.center_mm = {x.mid_mm(), y.mid_mm(), -10},
          .half_mm = {x.travel_mm() / 2 + 50, y.travel_mm() / 2 + 50, 10}};
}

std::vector<Solid> SolidsOf(const Artefact& artefact) {
  const double turn_rad = RadFromDeg(artefact.turn_deg);
  const Eigen::AngleAxisd turn(turn_rad, Vec3<double>::UnitZ());
  const auto part = [&](const Vec3<double>& center_mm, const Vec3<double>& half_mm) {
    return Solid{.center_mm = artefact.at_mm + turn * center_mm,
                 .half_mm = half_mm,
                 .turn_rad = turn_rad};
  };
  const Vec3<double>& size_mm = artefact.size_mm;
  switch (artefact.type) {
    case ArtefactType::kBlock123:
    case ArtefactType::kWeb:
    case ArtefactType::kPlate:
      return {part({0, 0, size_mm[2] / 2}, size_mm / 2)};
    case ArtefactType::kRing: {
      Solid ring = part({0, 0, size_mm[2] / 2},
                        {size_mm[0] / 2 + kRingWall_mm, 0, size_mm[2] / 2});
      ring.bore_radius_mm = size_mm[0] / 2;
      return {ring};
    }
    case ArtefactType::kPocket: {
      const double wall_mm = kPocketWall_mm / 2;
      const double off_mm = size_mm[0] / 2 + wall_mm;
      const double long_mm = size_mm[0] / 2 + kPocketWall_mm;
      const double z_mm = size_mm[2] / 2;
      return {part({-off_mm, 0, z_mm}, {wall_mm, long_mm, z_mm}),
              part({off_mm, 0, z_mm}, {wall_mm, long_mm, z_mm}),
              part({0, -off_mm, z_mm}, {long_mm, wall_mm, z_mm}),
              part({0, off_mm, z_mm}, {long_mm, wall_mm, z_mm})};
    }
    case ArtefactType::kLedge: {
      const double lip_mm = size_mm[2];
      const double back_mm = -size_mm[1] / 2 + kPillarDepth_mm / 2;
      return {part({0, 0, kLipHeight_mm + lip_mm / 2},
                   {size_mm[0] / 2, size_mm[1] / 2, lip_mm / 2}),
              part({0, back_mm, kLipHeight_mm / 2},
                   {size_mm[0] / 2, kPillarDepth_mm / 2, kLipHeight_mm / 2})};
    }
  }
  return {};
}

SurfaceDistance DistanceTo(const Solid& solid, const Vec3<double>& p_mm) {
  SurfaceDistance nearest;
  const Vec3<double> off_mm = p_mm - solid.center_mm;
  if (solid.bore_radius_mm > 0) {
    const double rho_mm = std::hypot(off_mm[0], off_mm[1]);
    const double wall_mm = (solid.half_mm[0] - solid.bore_radius_mm) / 2;
    Eigen::Vector2d gradient;
    nearest.distance_mm =
        BoxDistance<2>({rho_mm - solid.bore_radius_mm - wall_mm, off_mm[2]},
                       {wall_mm, solid.half_mm[2]},
                       &gradient);
    const double c = rho_mm > 0 ? off_mm[0] / rho_mm : 1;
    const double s = rho_mm > 0 ? off_mm[1] / rho_mm : 0;
    nearest.normal = {gradient[0] * c, gradient[0] * s, gradient[1]};
    return nearest;
  }
  if (solid.turn_rad == 0) {
    nearest.distance_mm = BoxDistance<3>(off_mm, solid.half_mm, &nearest.normal);
    return nearest;
  }
  const Eigen::AngleAxisd turn(solid.turn_rad, Vec3<double>::UnitZ());
  Vec3<double> gradient;
  nearest.distance_mm =
      BoxDistance<3>(turn.inverse() * off_mm, solid.half_mm, &gradient);
  nearest.normal = turn * gradient;
  return nearest;
}

namespace {

// Not more than the distance to an upright box: the farthest of its three slabs.
double AtLeast_mm(const Solid& solid, const Vec3<double>& p_mm) {
  if (solid.turn_rad != 0 || solid.bore_radius_mm > 0) return -1e9;
  return ((p_mm - solid.center_mm).cwiseAbs() - solid.half_mm).maxCoeff();
}

}  // namespace

SurfaceDistance NearestOf(const std::vector<Solid>& solids, const Vec3<double>& p_mm) {
  SurfaceDistance nearest;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (AtLeast_mm(solids[i], p_mm) >= nearest.distance_mm) continue;
    const SurfaceDistance candidate = DistanceTo(solids[i], p_mm);
    if (candidate.distance_mm >= nearest.distance_mm) continue;
    nearest = candidate;
    nearest.solid = i;
  }
  return nearest;
}

}  // namespace caltwin
