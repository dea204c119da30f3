#include "sim/kinds/cartesian/corners.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr int kZ = Index(Axis::kZ);
constexpr std::array kFollowing = {"Z1", "Z2", "Z3"};

const CornersDrawing& CornersOf(const Machine& machine) {
  return *machine.Own<CornersDrawing>();
}

// Where the head is, by the drawing.
Vec3<double> HeadAt_mm(const Machine& machine, const Motors& steps) {
  Vec3<double> drives_mm;
  Vec3<double> home_mm;
  for (const Axis axis : kAxes) {
    const auto i = static_cast<std::size_t>(Index(axis));
    home_mm[Index(axis)] = machine.axis(axis).home_mm();
    drives_mm[Index(axis)] = steps[Index(axis)] / machine.axes[i].steps_per_mm();
  }
  return home_mm + AxesOf(machine.kind->drive_map(), drives_mm);
}

}  // namespace

SteppedCorners::SteppedCorners(Built built, std::uint64_t seed)
    : machine_(built.machine), gantry_(std::move(built), seed) {}

Motors SteppedCorners::AsOne(const Motors& steps) const {
  Motors one = steps.head<3>();
  const Vec3<double> head_mm = HeadAt_mm(machine_, one);
  one[kZ] = CornersOf(machine_)
                .Weights(head_mm[0], head_mm[1])
                .dot(steps.tail<CornersDrawing::kNum>());
  return one;
}

bool SteppedCorners::Acts(const PinSensor& sensor, const Motors& steps) {
  const bool is_switch = sensor.kind == PinSensor::Kind::kSwitch;
  return gantry_.Acts(sensor, is_switch ? Motors(steps.head<3>()) : AsOne(steps));
}

Wiring WiringOfCorners(const Machine& machine) {
  constexpr std::array kUneven_mm = {0.9, -0.7, 1.3};
  Wiring wiring = WiringOfGantry(machine);
  const double steps_per_mm = machine.axis(Axis::kZ).steps_per_mm();
  const double first_steps = wiring.motors.back().start_steps;
  for (std::size_t i = 0; i < kFollowing.size(); ++i) {
    wiring.motors.push_back(
        {.name = kFollowing[i],
         .start_steps = first_steps + std::round(kUneven_mm[i] * steps_per_mm)});
  }
  return wiring;
}

std::unique_ptr<PlantBoard> BoardOfGantry(const Built& built, std::uint64_t seed) {
  if (built.machine.Own<CornersDrawing>() != nullptr) {
    return std::make_unique<PlantBoard>(WiringOfCorners(built.machine),
                                        std::make_unique<SteppedCorners>(built, seed));
  }
  return std::make_unique<PlantBoard>(WiringOfGantry(built.machine),
                                      std::make_unique<SteppedGantry>(built, seed));
}

std::string CornersCfg(const Machine& machine) {
  const AxisDrawing& z = machine.axis(Axis::kZ);
  std::string text;
  for (std::size_t i = 0; i < kFollowing.size(); ++i) {
    text += klipper::StepperCfg({.section = fmt::format("stepper_z{}", i + 1),
                                 .pin = kFollowing[i],
                                 .full_steps_per_rev = z.full_steps_per_rev,
                                 .microsteps = z.microsteps,
                                 .mm_per_rev = z.full_steps_per_rev * z.microsteps /
                                               machine.settings.steps_per_mm[kZ],
                                 .has_endstop = false});
  }
  const CornersDrawing& corners = CornersOf(machine);
  const auto at = [&](const Eigen::Vector2d& place_mm) {
    return klipper::CfgNumber(place_mm[0]) + ", " + klipper::CfgNumber(place_mm[1]);
  };
  const auto inside = [&](double u, double v) {
    const AxisDrawing& x = machine.axis(Axis::kX);
    const AxisDrawing& y = machine.axis(Axis::kY);
    return at({x.min_mm + u * x.travel_mm(), y.min_mm + v * y.travel_mm()});
  };
  constexpr double kLow = 0.1, kHigh = 0.9;
  return text + fmt::format(
                    "\n[quad_gantry_level]\ngantry_corners:\n  {}\n  {}\n"
                    "points:\n  {}\n  {}\n  {}\n  {}\n"
                    "speed: 150\nhorizontal_move_z: 10\nretries: 5\n"
                    "retry_tolerance: 0.0075\nmax_adjust: 10\n",
                    at(corners.low_mm),
                    at(corners.high_mm),
                    inside(kLow, kLow),
                    inside(kLow, kHigh),
                    inside(kHigh, kHigh),
                    inside(kHigh, kLow));
}

double FlatnessOfCorners_mm(const Built& built, const Motors& steps) {
  constexpr int kSide = 7;
  constexpr double kMargin = 0.05, kLifted_mm = 50;
  const Machine& machine = built.machine;
  const double z_per_mm = machine.axis(Axis::kZ).steps_per_mm();
  const Vec3<double> home_mm(machine.axes[0].home_mm(), machine.axes[1].home_mm(), 0);
  Eigen::ArrayXd heights_mm(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    Vec3<double> at_mm = Vec3<double>::Zero();
    const std::array places = {i % kSide, i / kSide};
    for (std::size_t k = 0; k < places.size(); ++k) {
      const double share =
          kMargin + (1 - 2 * kMargin) * places[k] / static_cast<double>(kSide - 1);
      at_mm[static_cast<Eigen::Index>(k)] =
          machine.axes[k].min_mm + share * machine.axes[k].travel_mm();
    }
    Vec3<double> head_steps = DrivesOf(machine.kind->drive_map(), at_mm - home_mm);
    for (int k = 0; k < 2; ++k) {
      head_steps[k] *= machine.axes[static_cast<std::size_t>(k)].steps_per_mm();
    }
    head_steps[kZ] = CornersOf(machine)
                         .Weights(at_mm[0], at_mm[1])
                         .dot(steps.tail<CornersDrawing::kNum>()) +
                     kLifted_mm * z_per_mm;
    heights_mm[i] =
        built.Clearance(built.Tip_mm(head_steps, built.lag_center_mm)).distance_mm;
  }
  return std::sqrt((heights_mm - heights_mm.mean()).square().mean());
}

}  // namespace caltwin
