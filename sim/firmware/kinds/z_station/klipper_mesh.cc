// Klipper's bed mesh, as far as it sets a nozzle's height.
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/firmware/kinds/z_station/klipper.h"

namespace caltwin {
Eigen::Vector2d BedMeshConfig::PointAt_mm(int index) const {
  const Eigen::Array2d step_mm =
      (max_mm - min_mm).array() / Eigen::Array2d(count[0] - 1.0, count[1] - 1.0);
  const int column = index % count[0], row = index / count[0];
  return min_mm + (step_mm * Eigen::Array2d(column, row)).matrix();
}

std::optional<Eigen::Vector2d> KlipperZ::BedPoint_mm() const {
  if (config_.probe_bed_at_mm) return config_.probe_bed_at_mm;
  if (!config_.bed_mesh) return config_.middle_mm;
  const auto& index = config_.bed_mesh->relative_reference_index;
  if (!index) return std::nullopt;
  return config_.bed_mesh->PointAt_mm(*index);
}

Reply KlipperZ::CalibrateMesh() {
  if (!config_.bed_mesh)
    return KlipperRefusal("Unknown command:\"BED_MESH_CALIBRATE\"");
  rests_at_mm_.reset();  // It lifts before its first point.
  if (const auto lacks = Lacks(ZTouch::kProbeOnBed)) return KlipperRefusal(*lacks);
  const BedMeshConfig& mesh = *config_.bed_mesh;
  mesh_mm_.clear();
  std::vector<double> heights_mm;
  std::string error;
  for (int i = 0; i < mesh.count[0] * mesh.count[1]; ++i) {
    Travel(mesh.PointAt_mm(i));
    const auto touched = Touch(ZTouch::kProbeOnBed, &error);
    if (!touched) return KlipperRefusal(error);
    heights_mm.push_back(*touched);
  }
  // Without a point of reference heights are the probe's own, over its z_offset.
  const double zero_mm =
      mesh.relative_reference_index
          ? heights_mm[static_cast<std::size_t>(*mesh.relative_reference_index)]
          : config_.probe_z_offset_mm;
  for (double& height_mm : heights_mm) {
    height_mm -= zero_mm;
  }
  mesh_mm_ = std::move(heights_mm);
  return {.lines = {"Mesh Bed Leveling Complete"}};
}

// Bilinear; beyond its edge as at the edge.
double KlipperZ::Mesh_mm(const Eigen::Vector2d& at_mm) const {
  if (mesh_mm_.empty()) return 0;
  const BedMeshConfig& mesh = *config_.bed_mesh;
  std::array<int, 2> cell{};
  std::array<double, 2> part{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double along = (at_mm[axis] - mesh.min_mm[axis]) /
                         (mesh.max_mm[axis] - mesh.min_mm[axis]) * (mesh.count[k] - 1);
    const double inside = std::clamp(along, 0.0, mesh.count[k] - 1.0);
    cell[k] = std::min(static_cast<int>(inside), mesh.count[k] - 2);
    part[k] = inside - cell[k];
  }
  const auto node_mm = [&](int right, int back) {
    const int index = (cell[1] + back) * mesh.count[0] + cell[0] + right;
    return mesh_mm_[static_cast<std::size_t>(index)];
  };
  const double front_mm = std::lerp(node_mm(0, 0), node_mm(1, 0), part[0]);
  const double rear_mm = std::lerp(node_mm(0, 1), node_mm(1, 1), part[0]);
  return std::lerp(front_mm, rear_mm, part[1]);
}

}  // namespace caltwin
