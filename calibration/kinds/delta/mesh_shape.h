#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A place of a bed that a delta probed, as its firmware believed it.
struct BedPoint {
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;
};

/// What may bend a probed bed beyond Klipper's six numbers. Those six already take its
/// height and tilt, and nearly all of a bed of the second order: delta radius looks
/// like a bowl, two tower angles like a cylinder and a twist.
enum class MeshModel {
  kSix,   ///< Nothing more.
  kArms,  ///< Three free arm lengths.
  kBed,   ///< Bowl, cylinder and twist of the bed: x^2, y^2, x y.
  kCubic  ///< Any bed of the third order.
};
inline constexpr int kNumMeshModels = 4;

enum class MeshVerdict { kArms, kBedShape, kNeither, kCannotTell };
/// "arms", "bed shape", "neither", "cannot tell".
std::string Name(MeshVerdict verdict);

/// How one model does.
struct MeshFit {
  double rms_mm = 0;  ///< Of the points it was fitted to.
  /// Of blocks of the bed left out, one after the other; nullopt where the rest does
  /// not determine the model.
  std::optional<double> hold_out_rms_mm{};
  DeltaModel<double> model{};
  /// kArms: of the three lengths, for points good to 20 um.
  Eigen::Matrix3d arm_covariance_mm2 = Eigen::Matrix3d::Zero();
  std::array<double, 3> shape_mm{};  ///< kBed: x^2, y^2, 2 x y at the rim.
};

/// Which explanation of a probed bed the bed itself supports.
struct MeshShape {
  MeshVerdict verdict = MeshVerdict::kCannotTell;
  std::array<MeshFit, kNumMeshModels> fits{};  ///< By MeshModel.
  int num_blocks = 0;
  std::string reason{};  ///< One sentence.

  const MeshFit& of(MeshModel model) const {
    return fits[static_cast<std::size_t>(model)];
  }
};

/// Fits each model to where the carriages stood, motors = DeltaMotors(settings, point):
/// the nozzle by the fitted geometry at the height of the fitted bed. Points count as
/// good to 20 um; priors, about the settings: arms 3 mm, delta radius and endstops 10
/// mm, angles as arcs 5 mm, terms of the bed 0.5 mm at the rim. Held out are blocks of
/// a grid of 4 x 4 over the bed.
///
/// A model is better than another where its held-out rms is at least a tenth smaller
/// and the difference of squared errors over the blocks is more than twice its standard
/// error. "arms": better than the six numbers and than bowl, cylinder and twist, no
/// worse than any bed of the third order, and within 2 % of each other. "bed shape": a
/// bed of the second or third order better than the six numbers and than the arms.
/// "neither": no held-out rms is a tenth smaller than that of the six numbers. Else
/// "cannot tell".
///
/// A bed of the third order stands for all that bends heights like one: leaning towers,
/// an effector that tilts with a probe beside the nozzle.
///
/// What no mesh tells: arms that differ lift the nozzle like x r^2 and y r^2 (one side
/// of the rim up, the other down): two of the four beds of the third order, none of the
/// first two. A plate bent in just that way looks the same; "arms" is said because
/// plates bend to the second order first, and that has been looked for and not found.
MeshShape ExplainMesh(std::span<const BedPoint> points,
                      const DeltaModel<double>& settings);

}  // namespace caltwin
