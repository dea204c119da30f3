#include "sim/controllers/plant_board.h"

#include <utility>

namespace caltwin {
namespace {

constexpr int kPinsPerMotor = 2;
constexpr int kSparePins = 16;

}  // namespace

Motors InPlant(const Wiring& wiring, const Motors& steps) {
  Motors own(steps.size());
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const Wiring::Motor& motor = wiring.motors[static_cast<std::size_t>(i)];
    own[i] = motor.start_steps + motor.sense * steps[i];
  }
  return own;
}

PlantBoard::PlantBoard(Wiring wiring, std::unique_ptr<SteppedPlant> plant)
    : wiring_(std::move(wiring)), plant_(std::move(plant)) {
  for (const Wiring::Motor& motor : wiring_.motors) {
    pins_.push_back(motor.name + "_STEP");
    pins_.push_back(motor.name + "_DIR");
  }
  for (const Wiring::Input& input : wiring_.inputs) pins_.push_back(input.pin);
  for (int i = 0; i < kSparePins; ++i) pins_.push_back("SPARE" + std::to_string(i));
  Follow(Motors::Zero(num_motors()));
}

std::optional<int> PlantBoard::MotorAt(int pin) const {
  const int motor = pin / kPinsPerMotor;
  if (pin % kPinsPerMotor != 0 || motor >= num_motors()) return std::nullopt;
  return motor;
}

const PinSensor* PlantBoard::SensorAt(int pin) const {
  const int first = kPinsPerMotor * num_motors();
  const auto at = static_cast<std::size_t>(pin - first);
  const bool is_input = pin >= first && at < wiring_.inputs.size();
  return is_input ? &wiring_.inputs[at].sensor : nullptr;
}

bool PlantBoard::IsHigh(int pin, const Motors& steps) {
  const PinSensor* const sensor = SensorAt(pin);
  return sensor != nullptr && plant_->Acts(*sensor, InPlant(wiring_, steps));
}

double PlantBoard::Analog(int /*pin*/) const {
  return 0.5;
}

void PlantBoard::Arm(int pin) {
  if (const PinSensor* const sensor = SensorAt(pin)) plant_->Arm(*sensor);
}

void PlantBoard::Follow(const Motors& steps) {
  plant_->Follow(InPlant(wiring_, steps));
}

}  // namespace caltwin
