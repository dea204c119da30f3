#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/firmware/plant.h"

namespace caltwin {

/// What is soldered to the pins of a controller. Motors are in steps as the controller
/// counts them: up where the direction pin is high, 0 where the board was switched on.
class Board {
 public:
  virtual ~Board() = default;
  /// Their names; a pin's number is its place.
  virtual std::span<const std::string> pins() const = 0;
  virtual int num_motors() const = 0;
  /// The motor of that step pin; nullopt: it has none.
  virtual std::optional<int> MotorAt(int pin) const = 0;
  /// Whether the pin reads high, the motors standing there. Changes nothing.
  virtual bool IsHigh(int pin, const Motors& steps) = 0;
  /// The pin's voltage as a share of the reference, 0..1.
  virtual double Analog(int pin) const = 0;
  /// A watch on that pin begins: chance is drawn for its next trigger.
  virtual void Arm(int pin) = 0;
  /// The motors have come straight to there from where they were last followed to.
  virtual void Follow(const Motors& steps) = 0;
};

}  // namespace caltwin
