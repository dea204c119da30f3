#include "sim/kinds/cartesian/corners.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/kinds/cartesian/klipper.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr int kZ = Index(Axis::kZ);
constexpr std::array kFollowing = {"Z1", "Z2", "Z3"};

const CornersDrawing& CornersOf(const Machine& machine) {
  return *machine.Own<CornersDrawing>();
}

// Of Z the corners have the play, each its own.
Built WithoutPlayOfZ(Built built) {
  built.lost_motion_mm[kZ] = 0;
  std::erase_if(built.effects, [](const Injected& effect) {
    return effect.effect == EffectIndex<Backlash>() && effect.axis == "z";
  });
  return built;
}

}  // namespace

SteppedCorners::SteppedCorners(const Built& built, bool is_physics, std::uint64_t seed)
    : built_(built), gantry_(WithoutPlayOfZ(built), is_physics, seed) {}

Corners SteppedCorners::LagAt_mm(const Motors& steps) const {
  const Corners travel_mm =
      (steps.tail<CornersDrawing::kNum>() - steps_) / built_.steps_per_mm[kZ];
  Corners lag_mm;
  for (int i = 0; i < CornersDrawing::kNum; ++i) {
    lag_mm[i] = LagAfter_mm(lag_mm_[i], travel_mm[i], built_.lost_motion_mm[kZ]);
  }
  return lag_mm;
}

Motors SteppedCorners::AsOne(const Motors& steps, bool is_at_first) const {
  Motors one = steps.head<3>();
  const Corners nuts =
      steps.tail<CornersDrawing::kNum>() + built_.steps_per_mm[kZ] * LagAt_mm(steps);
  const Vec3<double> head_mm = built_.Drawn_mm(one);
  const Corners weights = CornersOf(built_.machine).Weights(head_mm[0], head_mm[1]);
  one[kZ] = is_at_first ? nuts[0] : weights.dot(nuts);
  return one;
}

bool SteppedCorners::Acts(const PinSensor& sensor, const Motors& steps) {
  const bool is_switch = sensor.kind == PinSensor::Kind::kSwitch;
  return gantry_.Acts(sensor, AsOne(steps, /*is_at_first=*/is_switch));
}

void SteppedCorners::Follow(const Motors& steps) {
  gantry_.Follow(AsOne(steps, /*is_at_first=*/false));
  lag_mm_ = LagAt_mm(steps);
  steps_ = steps.tail<CornersDrawing::kNum>();
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

Wiring WiringOf(const Machine& machine) {
  const bool has_corners = machine.Own<CornersDrawing>() != nullptr;
  return has_corners ? WiringOfCorners(machine) : WiringOfGantry(machine);
}

BoardWithTip BoardOfGantry(const Built& built, bool is_physics, std::uint64_t seed) {
  std::unique_ptr<SteppedTip> plant;
  if (built.machine.Own<CornersDrawing>() != nullptr) {
    plant = std::make_unique<SteppedCorners>(built, is_physics, seed);
  } else {
    plant = std::make_unique<SteppedGantry>(built, is_physics, seed);
  }
  SteppedTip* const seen = plant.get();
  return {
      .board = std::make_unique<PlantBoard>(WiringOf(built.machine), std::move(plant)),
      .plant = seen};
}

std::string CornersCfg(const Machine& machine) {
  std::string text;
  for (std::size_t i = 0; i < kFollowing.size(); ++i) {
    klipper::StepperText motor =
        StepperOf(machine, Axis::kZ, fmt::format("stepper_z{}", i + 1), kFollowing[i]);
    motor.has_endstop = false;
    text += klipper::StepperCfg(motor);
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

double OverTableAt_mm(const Built& built,
                      const Motors& steps,
                      const Eigen::Vector2d& at_mm) {
  constexpr double kLifted_mm = 50;
  const Machine& machine = built.machine;
  Vec3<double> axes_mm = Vec3<double>::Zero();
  axes_mm.head<2>() = at_mm;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    axes_mm[Index(axis)] -= machine.axis(axis).home_mm();
  }
  Vec3<double> head_steps = DrivesOf(machine.kind->drive_map(), axes_mm);
  for (int k = 0; k < 2; ++k) {
    head_steps[k] *= machine.axes[static_cast<std::size_t>(k)].steps_per_mm();
  }
  head_steps[kZ] = CornersOf(machine)
                       .Weights(at_mm[0], at_mm[1])
                       .dot(steps.tail<CornersDrawing::kNum>()) +
                   kLifted_mm * machine.axis(Axis::kZ).steps_per_mm();
  return built.Clearance(built.Tip_mm(head_steps, built.lag_center_mm)).distance_mm;
}

double FlatnessOfCorners_mm(const Built& built, const Motors& steps) {
  constexpr int kSide = 7;
  constexpr double kMargin = 0.05;
  Eigen::ArrayXd heights_mm(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
    const std::array places = {i % kSide, i / kSide};
    for (std::size_t k = 0; k < places.size(); ++k) {
      const AxisDrawing& axis = built.machine.axes[k];
      const double share =
          kMargin + (1 - 2 * kMargin) * places[k] / static_cast<double>(kSide - 1);
      at_mm[static_cast<Eigen::Index>(k)] = axis.min_mm + share * axis.travel_mm();
    }
    heights_mm[i] = OverTableAt_mm(built, steps, at_mm);
  }
  return std::sqrt((heights_mm - heights_mm.mean()).square().mean());
}

}  // namespace caltwin
