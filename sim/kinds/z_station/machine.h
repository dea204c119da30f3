#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/kinds/z_station/world.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/measure/row.h"

namespace caltwin {

/// How the parts stand, the bed where it is probed. The errors are those of 20 degC.
ZStationBuild BuildOf(const Machine& machine, const std::vector<Injected>& effects);

/// A printer's station put through single readings, in closed form or in MuJoCo.
///
/// Heights are counted from where Z was homed: the nozzle on the endstop switch, as it
/// was at the first reading of the homing session. Effects say how long the nozzle is,
/// how thick the ooze, where the surface lies and when the knob triggers; contacts and
/// the springs of both switches are MuJoCo's.
class ZStationMachine {
 public:
  ZStationMachine(const Machine& machine,
                  const std::vector<Injected>& effects,
                  bool is_physics);

  /// (reported - nominal) . n of a touch; of a gap, what is there less commanded.
  /// Throws InputError at `row.place` where nothing triggers.
  double Reading_mm(const Row& row, const At& at);

 private:
  /// Height of the head, nozzle tip as drawn, at which that triggers.
  double Trigger_mm(const Row& row, const At& at, ZReading reading);
  double Gap_mm(const Row& row, const At& at);

  Machine machine_;
  std::vector<Injected> effects_;
  std::unique_ptr<ZStationWorld> world_{};       ///< Null: in closed form.
  std::map<std::string, double> homed_at_mm_{};  ///< By homing.
};

}  // namespace caltwin
