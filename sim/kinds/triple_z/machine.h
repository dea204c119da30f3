#pragma once

#include <memory>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/kinds/triple_z/world.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A triple-Z printer in MuJoCo, put through single readings, as MeasuringMachine does
/// with a gantry.
///
/// What the drives do to the screws (pitch, waves, gaps, swapped motors) is where the
/// nuts are driven to; pivots are where the screws stand in the model; guides that hold
/// the bed level turn it back while the nuts stand on springs; what the gantry
/// does is where the nozzle hangs; the bed's shape is on what can be touched. Balls,
/// bed and contact are MuJoCo's.
class TripleZMachine {
 public:
  TripleZMachine(const Machine& machine, const std::vector<Injected>& effects);

  /// Stands there and tells (actual - commanded) . n: the nozzle's height over the bed.
  double Gauge_mm(const At& at);
  /// Raises the bed until it meets the nozzle: (reported - nominal) . n, to fractions
  /// of a step. Throws InputError at `row.place` where it never does.
  double Touch_mm(const Row& row, const At& at);

 private:
  Vec3<double> Nuts_mm(const At& at) const;
  /// Over the bed's plane of balls that is drawn level.
  Vec3<double> Tip_mm(const At& at) const;
  BedSpot SpotAt(const At& at) const;
  double AfterContact_mm(const At& nominal, double contact_mm, double give_mm) const;
  double SurfaceAt_mm(At at, double dx_mm, double dy_mm) const;

  Machine machine_;
  std::vector<Injected> effects_;
  std::vector<Injected> drives_{};   ///< Of the screws: where the nuts are driven to.
  std::vector<Injected> build_{};    ///< Of screws and guides: in the model.
  std::vector<Injected> gantry_{};   ///< Stage kFrame.
  std::vector<Injected> surface_{};  ///< Stage kArtefact.
  Pivots<double> pivots_mm_{};       ///< Where the screws stand.
  std::unique_ptr<TripleZWorld> world_;
};

/// MuJoCo's world of a triple-Z printer with its screws there.
TripleZWorld WorldOfTripleZ(const Machine& machine,
                            const Pivots<double>& pivots_mm,
                            bool with_looks,
                            double held_mm2 = 0);

/// Where the screws stand as built.
Pivots<double> BuiltPivots_mm(const Machine& machine,
                              const std::vector<Injected>& effects);

}  // namespace caltwin
