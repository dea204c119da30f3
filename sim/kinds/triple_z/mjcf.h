#pragma once

#include <filesystem>
#include <string>

#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// A triple-Z printer's MuJoCo model as an editable specification, millimetres outside.
/// Names are those of models/triple_z_printer/model.xml: bodies `nut_z1`, `screw_z1`
/// (looks; may be missing), `bed`, `groove`, `flat`, `head`, joints `z1`, `bed`,
/// `groove`, `flat_x`, `flat_y`, equalities `cup_ball`, `groove_ball`, `flat_ball`,
/// geoms `nozzle` and `spot`.
class TripleZMjcf {
 public:
  /// Throws InputError where the file is no model of this shape (a name above missing).
  static TripleZMjcf FromFile(const std::filesystem::path& file);

  /// Step [s]; balls become dead-beat, contacts hard.
  void SetTimestep_s(double timestep_s);
  /// Stands the screws there, and the bed's cup, groove and flat over them.
  void SetPivots(const Pivots<double>& pivots_mm);
  /// Nuts that are not driven but pushed: so heavy, so damped; weight, to which a bed
  /// has settled when it is homed, is left out.
  void LetScrewsGive(double nut_kg, double damping_n_s_per_m);

  /// Throws logic_error with MuJoCo's words where it does not compile.
  ModelPtr Compile(bool with_looks) const;

 private:
  explicit TripleZMjcf(SpecPtr spec) : spec_(std::move(spec)) {}
  void CheckNames(const std::string& file) const;

  SpecPtr spec_;
};

}  // namespace caltwin
