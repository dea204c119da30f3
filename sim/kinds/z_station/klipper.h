#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "sim/base/rng.h"
#include "sim/controllers/plant_board.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/kinds/z_station/station.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A head with nozzle and attached switch probe over its endstop switch and bed, whose
/// three motors are stepped one by one. Motors x y z, in steps from the axes' home ends
/// and, of z, from the drawn nozzle's tip on the bare bed. The probe's knob is
/// `kProbeOff_mm` from the nozzle; within `kSwitchReach_mm` of the switch, nozzle and
/// body press it.
class SteppedStation final : public SteppedPlant {
 public:
  static constexpr std::array<double, 2> kProbeOff_mm = {0, 25};
  static constexpr double kSwitchReach_mm = 3;

  /// @param is_physics  contacts and the switches' springs are MuJoCo's
  SteppedStation(const Machine& machine,
                 const ZStation& station,
                 bool is_physics,
                 std::uint64_t seed);

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& /*steps*/) override {}
  void Arm(const PinSensor& sensor) override;

 private:
  bool IsDownAt(ZTouch touch,
                const Eigen::Vector2d& at_mm,
                double carriage_mm,
                double late_mm);

  Machine machine_;
  ZStation station_;
  ZStationTwin quiet_;  ///< Without chance, which is drawn once a watch.
  Rng rng_;
  double endstop_late_mm_ = 0, probe_late_mm_ = 0;
};

/// Motors X, Y, Z with X_STOP, Y_STOP; Z_STOP is the endstop switch, PROBE the probe.
Wiring WiringOfStation(const Machine& machine);

/// The printer.cfg of such a printer, with z_calibration as drawn.
std::string PrinterCfgOfStation(const Machine& machine, const std::string& serial);

}  // namespace caltwin
