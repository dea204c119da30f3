#pragma once

#include <filesystem>
#include <string>

#include "sim/machine/delta_touch.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

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

  /// Throws logic_error with MuJoCo's words where it does not compile.
  ModelPtr Compile(bool with_looks) const;

 private:
  explicit DeltaMjcf(SpecPtr spec) : spec_(std::move(spec)) {}
  void CheckNames(const std::string& file) const;
  void AddHeights(const DeltaBed<double>& bed);

  SpecPtr spec_;
};

}  // namespace caltwin
