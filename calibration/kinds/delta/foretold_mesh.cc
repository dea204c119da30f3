#include "calibration/kinds/delta/foretold_mesh.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

DeltaMesh ForetoldMesh(const DeltaJointFit& fit,
                       const DeltaModel<double>& settings,
                       double radius_mm,
                       int nodes) {
  DeltaMesh mesh{.radius_mm = radius_mm, .nodes = nodes};
  for (int row = 0; row < nodes; ++row) {
    for (int column = 0; column < nodes; ++column) {
      const Eigen::Vector2d node(mesh.Node_mm(column), mesh.Node_mm(row));
      const double out_mm = node.norm();
      const Eigen::Vector2d at = out_mm > radius_mm ? node * radius_mm / out_mm : node;
      const Vec3<double> motors_mm =
          DeltaMotors_mm<double>(settings, {at[0], at[1], 0});
      mesh.height_mm.push_back(-ForetellHeight(fit, motors_mm).height_mm);
    }
  }
  return mesh;
}

std::string MeshAsMarlin(const DeltaMesh& mesh) {
  std::string text;
  for (int row = 0; row < mesh.nodes; ++row) {
    for (int column = 0; column < mesh.nodes; ++column) {
      text += fmt::format("M421 I{} J{} Z{:.4f}\n", column, row, mesh.At(column, row));
    }
  }
  return text + "M420 S1\n";
}

std::string MeshAsKlipper(const DeltaMesh& mesh) {
  std::string text = "[bed_mesh default]\nversion = 1\npoints =\n";
  for (int row = 0; row < mesh.nodes; ++row) {
    text += "  ";
    for (int column = 0; column < mesh.nodes; ++column) {
      text += fmt::format("{}{:.6f}", column == 0 ? "" : ", ", mesh.At(column, row));
    }
    text += "\n";
  }
  const double far_mm = mesh.radius_mm;
  return text + fmt::format(
                    "x_count = {0}\ny_count = {0}\nmesh_x_pps = 0\n"
                    "mesh_y_pps = 0\nalgo = direct\ntension = 0.2\n"
                    "min_x = {1:.1f}\nmax_x = {2:.1f}\nmin_y = {1:.1f}\n"
                    "max_y = {2:.1f}\n",
                    mesh.nodes,
                    -far_mm,
                    far_mm);
}

}  // namespace caltwin
