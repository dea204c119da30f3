#pragma once

#include <array>
#include <memory>
#include <optional>

#include "sim/kinds/triple_z/mjcf.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/physics/world.h"

namespace caltwin {

/// The bed's surface about one place, in the bed's own frame: its height over the plane
/// of the balls, and its slopes there.
struct BedSpot {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double height_mm = 0;
  double slope_x = 0, slope_y = 0;
};

/// A compiled triple-Z printer with its state, millimetres outside. The nuts are driven
/// exactly (dead-beat); balls, bed and contact are MuJoCo's. Where guides hold the bed
/// level (OverconstrainedBed) the nuts stand on springs, and a moment turns the bed
/// back in proportion to its tilt: what it does is MuJoCo's balance.
class TripleZWorld {
 public:
  /// `pivots_mm`: as the model was given them. `held_mm2`: turning stiffness of the
  /// guides over that of one screw's support; above 0 the model is one of
  /// LetScrewsGive(kNut_kg, kNutDamping_n_s_per_m).
  TripleZWorld(ModelPtr model, const Pivots<double>& pivots_mm, double held_mm2 = 0);

  /// Of a nut that gives. Only the ratio of stiffnesses shows at rest.
  static constexpr double kScrew_n_per_m = 2e5;
  static constexpr double kNut_kg = 1;
  static constexpr double kNutDamping_n_s_per_m = 750;

  double timestep_s() const { return model_->opt.timestep; }
  /// Where the nozzle hangs in the machine's frame, z over the lower endstops.
  void HangNozzle(const Vec3<double>& tip_mm);
  /// What of the bed can be touched.
  void SetSpot(const BedSpot& spot);
  /// Puts the screws there, all of them at that speed, and the bed on them, forgetting
  /// what was.
  void Place(const Vec3<double>& heights_mm, double speed_mm_s);
  /// One time step, after which the nuts stand at `heights_mm`.
  void Step(const Vec3<double>& heights_mm);
  /// Steps until the bed is at rest on the nuts, to some nanometres.
  int settle_steps() const { return held_n_m_ > 0 ? 150 : 3; }

  /// Of the instant before the last Step: contacts are found at a step's beginning.
  std::optional<double> Clearance_mm() const;
  /// Height of the bed's plane of balls over a place of the machine, now.
  double Plane_mm(const Eigen::Vector2d& at_mm) const;

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  void DriveNuts(const Vec3<double>& heights_mm);
  void PushNuts(const Vec3<double>& heights_mm);
  void TurnBedBack();

  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  Pivots<double> pivots_mm_;
  std::array<int, kNumScrews> qpos_{}, dof_{};
  std::array<double, kNumScrews> mass_kg_{};
  double held_n_m_ = 0;  ///< Per rad.
  Vec3<double> told_mm_ = Vec3<double>::Zero();
  int bed_qpos_ = 0, bed_dof_ = 0, bed_body_ = 0;
  int groove_qpos_ = 0, flat_x_qpos_ = 0, flat_y_qpos_ = 0;
  int spot_geom_ = 0, head_mocap_ = 0;
};

}  // namespace caltwin
