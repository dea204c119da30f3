#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/mjcf/mjcf.h"
#include "sim/physics/coupled_joints.h"

namespace caltwin {

struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// A compiled machine with its state, in millimetres and newtons outside.
///
/// The motors are exact: before each step the nuts get the force that puts them where
/// they are told to be one step later (dead-beat, 1e-5 um). Everything else (carriages
/// in their gaps, friction, stylus, contact) is MuJoCo's.
///
/// A nut, its play and its gap are a drive's: that of the axis it is called by, or of
/// the drive with that axis' index where drives move the axes together. Then the play's
/// tendon holds several carriages (CoreXY: x + y - a).
class World {
 public:
  /// @param hanging_n  load along -z on the vertical carriage: weight less
  /// counterbalance
  World(ModelPtr model, double hanging_n);

  double timestep_s() const;
  /// Puts the machine there, stylus at rest, forgetting what was: nuts and carriages at
  /// these positions and speeds. The nuts come to stand exactly there, each carriage as
  /// far from its nut as told, by the model's own coupling (tendon `x_play`); joints
  /// that an equality ties to them follow.
  void Place(const Vec3<double>& nuts_mm,
             const Vec3<double>& carriages_mm,
             const Vec3<double>& nuts_mm_s,
             const Vec3<double>& carriages_mm_s);
  /// One time step, after which the nuts stand at `nuts_mm`.
  void Step(const Vec3<double>& nuts_mm);

  /// @name Changes while it runs, effective from the next Step, Place or Clearance on
  /// Stands the stylus that far from where the model has it on the z carriage.
  void MoveTool_mm(const Vec3<double>& offset_mm);
  /// Moves the table, with all that stands on it, from where the model has it: raised
  /// by `height_mm` at `about_mm` and tilted about it to these slopes (height gained
  /// per length along +x and +y). Calls do not add up; heights of 0 bring it back.
  void SetTable(const Vec3<double>& about_mm,
                double height_mm,
                double slope_x,
                double slope_y);
  /// The width of the play between nut and carriage, about its middle as modelled; 0
  /// couples them firmly (or by the drive's spring, where it has one).
  void SetGap_mm(Axis axis, double gap_mm);
  /// That width as it is now, also where a person wrote it into the model.
  double Gap_mm(Axis axis) const;

  /// Friction between a carriage and its rail.
  void SetRailFriction_n(Axis axis, double friction_n);
  /// Turns the table, with what was put on it by hand, about a vertical, from where the
  /// model has it; a tilt of the model stays as it is. Undone by SetTable.
  void TurnTable(const Vec3<double>& about_mm, double turn_rad);

  /// @name A model with a target (Mjcf::AddTarget): what the stylus may touch
  /// The target alone: its face at a point of the table's own frame, with that outward
  /// normal.
  void PlaceTarget(const Vec3<double>& at_mm, const Vec3<double>& normal);
  /// What was put on the table by hand alone.
  void TouchTable();
  /// Whether anything was.
  bool has_table_shape() const { return !touchable_.empty(); }

  Vec3<double> Nuts_mm() const;
  Vec3<double> Carriages_mm() const;
  Vec3<double> Carriages_mm_s() const;
  /// The ball's centre relative to its rest: what opens the switch.
  Vec3<double> Deflection_mm() const;
  Vec3<double> Deflection_mm_s() const;
  /// Where the ball's centre is at rest (undeflected), machine axes, tool offset and
  /// all.
  Vec3<double> Tip_mm() const;
  /// Least distance of the fitted stylus to anything touchable, where it is below
  /// `most_mm`; `most_mm` otherwise. MuJoCo's own geometry, not the closed form's.
  double Clearance_mm(double most_mm) const;

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  struct Slots {
    std::array<int, 3> qpos{};
    std::array<int, 3> dof{};
  };
  /// The coupling between a nut and its carriage.
  struct Play {
    int tendon = 0;
    int rigid = 0;  ///< Equality that holds it shut while active.
    /// Coefficients of the three carriages in the tendon's length: of one alone where
    /// its drive is its own.
    Vec3<double> carriages = Vec3<double>::Zero();
    double middle_m = 0;  ///< The length when the carriage is in the middle.
    bool is_sprung = false;
  };
  Slots SlotsOf(const std::string& prefix, const std::string& suffix) const;
  CoupledJoints Couplings() const;
  Play PlayOf(Axis axis) const;
  void MakeTouchable(int geom, bool is_touchable);
  /// How far what each drive pulls is ahead of it, by the coefficients of its play.
  Vec3<double> Lag_mm(const Vec3<double>& nuts_mm,
                      const Vec3<double>& carriages_mm) const;
  void SettlePlays(const Vec3<double>& lag_mm);
  static Vec3<double> Read_mm(const mjtNum* values, const std::array<int, 3>& at);

  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  Slots nuts_, carriages_, stylus_;
  int stylus_geom_ = 0;  ///< Ball or disc, whichever is fitted.
  int z_body_ = 0;
  int stylus_body_ = 0;
  int table_body_ = 0;
  /// As the model has them: what MoveTool_mm and SetTable start from [m].
  std::array<mjtNum, 3> stylus_pos_{}, table_pos_{};
  std::array<mjtNum, 4> table_quat_{};
  std::array<Play, 3> plays_{};
  bool is_coupled_ = false;  ///< A play holds several carriages.
  std::optional<CoupledJoints> couplings_{};
  std::vector<int> touchable_{};
  int target_body_ = -1, target_geom_ = -1;  ///< None: -1.
  bool is_target_touched_ = false;
  double hanging_n_ = 0;
  std::array<double, 3> nut_mass_kg_{};
};

}  // namespace caltwin
