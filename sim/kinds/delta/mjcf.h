#pragma once

#include <filesystem>
#include <string>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// A carriage that is loose in its drive.
struct DeltaPlay {
  int tower = 0;
  double gap_mm = 0;
  double friction_n = 0;  ///< Between carriage and rail.
  double carriage_kg = 0;
};

/// A delta's MuJoCo model as an editable specification, millimetres outside. Bodies,
/// joints, sites and tendons are those of models/delta_printer/model.xml: bodies
/// `carriage_a`, `effector`, `bed`, joints `a` (up is +, 0 at the endstop), sites
/// `upper_a1`, `lower_a1`, tendons and equalities `rod_a1`, geoms `nozzle`, `bed`.
class DeltaMjcf {
 public:
  /// Throws InputError where the file is no model of this shape (a name above missing).
  static DeltaMjcf FromFile(const std::filesystem::path& file);
  /// A copy to edit.
  DeltaMjcf Copy() const;

  /// Step [s]; rods become dead-beat, contacts hard.
  void SetTimestep_s(double timestep_s);
  /// Puts towers, joints and tool where this machine has them. Rods get their length
  /// from DeltaWorld.
  void SetBuild(const DeltaBuild<double>& build);
  /// The bed as a plane, or, where it has a shape, as a height field of 1 mm cells (a
  /// bowl of 0.2 mm over 100 mm: right to 0.005 um).
  void SetBed(const DeltaBed<double>& bed);

  /// A sprung probe with its tip there: body `probe` on the effector, joint `probe`
  /// along the tool (+: pushed in, 0: at rest on its stop), held out by half a newton
  /// and 50 N/m. The nozzle touches nothing any more. Call it before SetTimestep_s.
  void AddProbe(const Vec3<double>& off_mm);

  /// What touches without a probe: the nozzle's tip, or something as hard beside it.
  void MoveNozzle(const Vec3<double>& off_mm);

  /// Parts a carriage from its drive: a body `drive_a` that the motor moves (joint
  /// `drive_a`) and the carriage, which its rail holds by friction and which the drive
  /// takes along once the gap is crossed. The friction never acts on the gap itself:
  /// there it would close it. Call it after SetBuild and before SetTimestep_s.
  void AddPlay(const DeltaPlay& play);
  /// What hangs on the rods.
  void SetEffectorMass_kg(double mass_kg);

  /// Throws logic_error with MuJoCo's words where it does not compile.
  ModelPtr Compile(bool with_looks) const;

 private:
  explicit DeltaMjcf(SpecPtr spec) : spec_(std::move(spec)) {}
  void CheckNames(const std::string& file) const;
  void HardenPlay(int tower, double timestep_s);
  void AddHeights(const DeltaBed<double>& bed);

  SpecPtr spec_;
};

}  // namespace caltwin
