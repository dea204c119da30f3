#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/kinds/motor_stage/motor_axes.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/nobody.h"
#include "sim/base/rng.h"
#include "sim/firmware/kinds/motor_stage/controller.h"
#include "sim/kinds/motor_stage/rig.h"

namespace caltwin {

/// What a motor controller comes out of the factory with: its drawing in pulses.
MotorStageOptions MotorFirmwareOf(const MotorStageDrawing& drawing);

/// Reads where a carriage of the simulated stage is: `laser.x` [mm], `laser.a` [deg].
class MotorStageGauge : public Gauge {
 public:
  MotorStageGauge(const MotorStageRig* rig,
                  double sigma_unit,
                  std::uint64_t seed,
                  std::uint64_t sample)
      : rig_(rig), sigma_unit_(sigma_unit), noise_(seed, sample, "laser") {}
  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;

 private:
  const MotorStageRig* rig_;
  double sigma_unit_;
  Rng noise_;
};

/// Sets the fields of the record that the scenario's or truth file's `settings` name.
/// Throws InputError where the controller refuses one.
void SetFields(const MotorStageTruth& truth,
               const std::filesystem::path& file,
               MotorAxes* axes);

/// Where the axis' zero truly stands, beyond its MIN switch as drawn [mm, deg].
double TrueHome(const MotorStageFirmware& firmware,
                const MotorStageRig& rig,
                std::size_t axis);

}  // namespace caltwin
