#include "scenarios/kinds/delta_linuxcnc_trial.h"

#include <array>
#include <cmath>
#include <numbers>

#include "sim/kinds/delta/klipper.h"
#include "sim/kinds/delta/linuxcnc.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

// Where the nozzle is, the carriages so far below their switches.
Vec3<double> NozzleAt_mm(const BuiltDelta& built, const Vec3<double>& motors_mm) {
  const auto pose = DeltaPoseOf(built.build, motors_mm);
  return pose ? pose->nozzle_mm : Vec3<double>::Constant(std::nan(""));
}

}  // namespace

std::vector<Stop> DeltaLinuxCncTrial::Stops() const {
  constexpr int kOnRing = 7;
  const double radius_mm = DeltaOf(machine_).print_radius_mm;
  std::vector<Stop> stops;
  for (const double height_mm : {15.0, 80.0}) {
    stops.push_back({Vec3<double>(0, 0, height_mm)});
    for (const double share : {0.45, 0.9}) {
      for (int i = 0; i < kOnRing; ++i) {
        const double angle_rad = 2 * std::numbers::pi * i / kOnRing;
        stops.push_back({Vec3<double>(share * radius_mm * std::cos(angle_rad),
                                      share * radius_mm * std::sin(angle_rad),
                                      height_mm)});
      }
    }
  }
  return stops;
}

Vec3<double> DeltaLinuxCncTrial::Tip_mm(const Motors& steps) const {
  const Wiring wiring = WiringOfDelta(machine_);
  const std::array<double, 3> steps_per_mm = TowerStepsPerMm(machine_);
  Vec3<double> motors_mm;
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Wiring::Motor& motor = wiring.motors[at];
    motors_mm[i] = (motor.start_steps + motor.sense * steps[i]) / steps_per_mm[at];
  }
  return NozzleAt_mm(built_, motors_mm);
}

std::vector<Vec3<double>> DeltaLinuxCncTrial::Uncorrected_mm(
    const std::vector<Stop>& stops) const {
  std::vector<Vec3<double>> errors_mm;
  for (const Stop& stop : stops) {
    const Vec3<double> motors_mm =
        DeltaMotors_mm(DeltaOf(machine_).settings, stop.at_mm);
    errors_mm.push_back(NozzleAt_mm(built_, motors_mm) - stop.at_mm);
  }
  return errors_mm;
}

std::unique_ptr<KindTrial> BeginDeltaUnderLinuxCnc(const DeltaScenario& delta,
                                                   const Scenario& scenario,
                                                   const Chance& chance) {
  Machine machine = scenario.machine.machine;
  DeltaOf(machine).settings = delta.settings;
  BuiltDelta built = DrawDelta(delta, machine, chance.seed, chance.sample);
  auto board = std::make_unique<PlantBoard>(
      WiringOfDelta(machine),
      std::make_unique<SteppedDelta>(
          machine, built, chance.fidelity == Fidelity::kPhysics, chance.seed));
  return std::make_unique<DeltaLinuxCncTrial>(
      machine,
      std::move(built),
      std::move(board),
      Completed(*scenario.linuxcnc, LinuxCncOfDelta(machine)));
}

}  // namespace caltwin
