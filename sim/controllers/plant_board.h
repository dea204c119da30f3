#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/controllers/board.h"
#include "sim/firmware/stepped_plant.h"

namespace caltwin {

/// Which pins the parts of a machine are wired to. A motor has NAME_STEP and NAME_DIR;
/// inputs read high while they act.
struct Wiring {
  struct Motor {
    std::string name{};  ///< "A"
    int sense = 1;       ///< +1: the plant's steps count as the host's do; -1: against.
    double start_steps = 0;  ///< The plant's, when the board is switched on.
  };
  struct Input {
    std::string pin{};  ///< "A_STOP"
    PinSensor sensor{};
  };
  std::vector<Motor> motors{};  ///< In the plant's order.
  std::vector<Input> inputs{};
};

/// Where a plant's motors stand, in its own steps, that a board counts so.
Motors InPlant(const Wiring& wiring, const Motors& steps);

/// A board that drives a plant. Beside the pins of the wiring it has some that lead
/// nowhere, for fans, heaters and the like (SPARE0 to SPARE15); analog ones read half
/// the reference voltage.
class PlantBoard : public Board {
 public:
  PlantBoard(Wiring wiring, std::unique_ptr<SteppedPlant> plant);

  std::span<const std::string> pins() const override { return pins_; }
  int num_motors() const override { return static_cast<int>(wiring_.motors.size()); }
  std::optional<int> MotorAt(int pin) const override;
  bool IsHigh(int pin, const Motors& steps) override;
  double Analog(int pin) const override;
  void Arm(int pin) override;
  void Follow(const Motors& steps) override;

 private:
  const PinSensor* SensorAt(int pin) const;

  Wiring wiring_;
  std::unique_ptr<SteppedPlant> plant_;
  std::vector<std::string> pins_{};
};

}  // namespace caltwin
