#include "scenarios/kinds/gantry_linuxcnc_trial.h"

#include <cmath>
#include <utility>

#include "scenarios/kinds/gantry_trial.h"
#include "sim/kinds/cartesian/linuxcnc.h"

namespace caltwin {
namespace {

constexpr int kPlaces = 9;
/// From so far away a place is come to, and so far from its ends an axis is looked at.
constexpr double kRun_up_mm = 5, kMargin_mm = 10;

Vec3<double> Middle_mm(const Machine& machine) {
  Vec3<double> at_mm;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    // Well off the table.
    const double share = axis == Axis::kZ ? 0.8 : 0.5;
    at_mm[Index(axis)] = drawn.min_mm + share * drawn.travel_mm();
  }
  return at_mm;
}

// Places that are no round number of any table's, each from below and from above.
std::vector<Stop> Places(const Machine& machine) {
  constexpr double kOff = 0.37;
  const Vec3<double> middle_mm = Middle_mm(machine);
  std::vector<Stop> stops = {{middle_mm, /*is_looked_at=*/false}};
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    const double travel_mm = drawn.travel_mm() - 2 * kMargin_mm;
    for (const double sense : {1.0, -1.0}) {
      for (int i = 0; i < kPlaces; ++i) {
        Vec3<double> at_mm = middle_mm;
        at_mm[Index(axis)] =
            drawn.min_mm + kMargin_mm + travel_mm * (i + kOff) / kPlaces;
        Vec3<double> from_mm = at_mm;
        from_mm[Index(axis)] -= sense * kRun_up_mm;
        stops.push_back({from_mm, /*is_looked_at=*/false});
        stops.push_back({at_mm});
      }
    }
  }
  return stops;
}

}  // namespace

std::vector<Stop> GantryLinuxCncTrial::Stops() const {
  return Places(built_.machine);
}

std::vector<Vec3<double>> GantryLinuxCncTrial::Uncorrected_mm(
    const std::vector<Stop>& stops) const {
  SteppedGantry machine(built_, is_physics_, seed_);
  std::vector<Vec3<double>> errors_mm;
  for (const Stop& stop : stops) {
    Vec3<double> steps;
    for (const Axis axis : kAxes) {
      const auto i = static_cast<std::size_t>(Index(axis));
      steps[Index(axis)] =
          std::round((stop.at_mm[Index(axis)] - built_.machine.axis(axis).home_mm()) *
                     built_.machine.settings.steps_per_mm[i]);
    }
    machine.Follow(machine.TurnedOn(steps));
    if (stop.is_looked_at) errors_mm.push_back(machine.Tip_mm() - stop.at_mm);
  }
  return errors_mm;
}

std::unique_ptr<KindTrial> BeginGantryUnderLinuxCnc(const Scenario& scenario,
                                                    const Chance& chance) {
  const TwinConfig config = MakeTwinConfig(
      scenario,
      {.fidelity = chance.fidelity, .seed = chance.seed, .sample = chance.sample});
  Built built = BuiltUnderController(config);
  const Machine& machine = built.machine;
  UnderLinuxCnc asked = Completed(*scenario.linuxcnc, LinuxCncOfGantry(machine));
  const bool is_physics = config.fidelity == Fidelity::kPhysics;
  auto plant = std::make_unique<SteppedGantry>(built, is_physics, config.seed);
  const SteppedGantry* const seen = plant.get();
  auto board = std::make_unique<PlantBoard>(WiringOfGantry(machine), std::move(plant));
  return std::make_unique<GantryLinuxCncTrial>(std::move(built),
                                               is_physics,
                                               config.seed,
                                               std::move(board),
                                               seen,
                                               std::move(asked));
}

}  // namespace caltwin
