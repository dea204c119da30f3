#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include <mujoco/mujoco.h>

#include "sim/machine/drive_map.h"
#include "sim/machine/machine.h"
#include "sim/machine/surface.h"
#include "sim/mjcf/spec.h"

namespace caltwin {

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using ModelPtr = std::unique_ptr<mjModel, DeleteModel>;

/// A machine's MuJoCo model as an editable specification. Millimetres, newtons and
/// kilograms come in; metres exist only inside. Bodies, joints and tendons are those of
/// models/gantry_router/model.xml: joints `x`, `x_nut`, `stylus_x`, tendon `x_play`,
/// equality `x_rigid`, bodies `table`, `x_carriage`, `stylus`, geom `tip`.
class Mjcf {
 public:
  /// Throws InputError with MuJoCo's own words where the file is not a model of this
  /// shape (a name above missing).
  static Mjcf FromFile(const std::filesystem::path& file);
  /// The model of a machine that names none: bodies, joints and tendons without looks.
  /// Each drive's play holds the carriages that it moves; null: its own.
  static Mjcf GenericCartesian(const DriveMap* drives = nullptr);

  /// A copy to edit: 10 times faster than reading the file again.
  Mjcf Copy() const;

  Mjcf(Mjcf&&) noexcept = default;
  Mjcf& operator=(Mjcf&&) noexcept = default;

  /// Step [s]; every constraint's time constant becomes two steps (PHYSICS: 1000 times
  /// stiffer than MuJoCo's default), equalities between joints that a person wrote
  /// included.
  void SetTimestep_s(double timestep_s);
  /// Inertia along an axis, whatever hangs on it in the model (by armature).
  void SetMovingMass(Axis axis, double mass_kg);
  void SetRailFriction(Axis axis, double friction_n);
  /// The spring of the stylus, and beside its ball a disc of the same half height. The
  /// ball is fitted, and nothing else can touch but what a person gave a `contype` in
  /// the body `table`. Call once.
  void SetStylus(double tip_radius_mm,
                 double stiffness_n_per_mm,
                 double disc_radius_mm);
  void SetTipRadius(double radius_mm);
  /// Fits the disc in place of the ball, or back: only what is fitted can touch.
  void FitDisc(bool is_disc);
  /// A gap of this width between nut and carriage; 0 leaves them as they are.
  void SetGap(Axis axis, double gap_mm);
  /// A spring between nut and carriage, beyond the gap; call after SetGap.
  void SetDriveStiffness(Axis axis, double stiffness_n_per_mm);
  /// Turns the direction an axis runs in, right-handed about `about`, pivoting where
  /// the axis stands at `pivot_mm`. Turns add up.
  void TurnAxis(Axis axis, Axis about, double angle_rad, double pivot_mm);
  /// Lets a carriage leave its straight line as it moves, by `bow_mm` (U^2 - 1/3) along
  /// `across`, U = -1 .. 1 over the travel. Bows add up.
  void BendRail(Axis axis, Axis across, double bow_mm, const AxisDrawing& travel);
  /// Lets a carriage, and all it carries, turn as it moves, by `change_rad` U / 2,
  /// right-handed about `about` through `pivot_mm` (where that point of the carriage
  /// lies when all axes stand at 0).
  void TwistRail(Axis axis,
                 Axis about,
                 double change_rad,
                 const Vec3<double>& pivot_mm,
                 const AxisDrawing& travel);
  /// Tilts the table and all on it about `about_mm`, to exactly these slopes.
  void TiltTable(double slope_x_rad, double slope_y_rad, const Vec3<double>& about_mm);
  /// Adds what can be touched to the table; a bore becomes 720 flats that touch its
  /// circle (0.2 um inside it at the corners, for 50 mm).
  void AddSolid(const std::string& name, const Solid& solid);
  /// Adds a small block on the table, body `target`, which World::PlaceTarget stands
  /// where something is to be touched. Call before SetTimestep_s.
  void AddTarget();

  /// Throws logic_error with MuJoCo's words where it does not compile. Without looks,
  /// what cannot touch is left out: a step costs a third less.
  ModelPtr Compile(bool with_looks) const;
  std::string ToText() const;

 private:
  explicit Mjcf(mjSpec* spec) : spec_(spec) {}
  mjsJoint* Joint(const std::string& name) const;
  mjsTendon* Play(Axis axis) const;
  void FreeOfNut(Axis axis);
  mjsJoint* AddErrorJoint(Axis axis,
                          const std::array<double, 3>& over_travel,
                          const AxisDrawing& travel);
  void CheckNames(const std::string& file) const;

  SpecPtr spec_;
};

/// Brings a model in line with the machine file: masses, friction, stylus, table.
void ApplyDrawing(const Machine& machine, Mjcf* model);
/// The model a machine file names, or the generic one, with the drawing applied.
Mjcf ModelOf(const Machine& machine);

}  // namespace caltwin
