#pragma once

#include <stdexcept>

#include "sim/firmware/plant.h"

namespace caltwin {

/// The motors were sent where no such machine can be; `what()` says so.
class Jammed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a controller's pin can be wired to.
struct PinSensor {
  enum class Kind { kProbe, kSwitch };
  Kind kind = Kind::kProbe;
  int motor = 0;  ///< Whose switch, in the plant's order.
};

/// The mechanism of a controller that steps every motor by itself and looks at single
/// pins, at any time: where a Plant is led along a whole move and finds its end, this
/// one only says what a pin shows while the motors stand somewhere.
class SteppedPlant {
 public:
  virtual ~SteppedPlant() = default;
  /// Whether the sensor acts, the motors having come to `steps` straight from where
  /// they were last followed to. Changes nothing that a later answer depends on.
  virtual bool Acts(const PinSensor& sensor, const Motors& steps) = 0;
  /// The motors have come straight to there. May throw Jammed.
  virtual void Follow(const Motors& steps) = 0;
  /// A watch on it begins: chance is drawn for its next trigger.
  virtual void Arm(const PinSensor& sensor) = 0;
};

}  // namespace caltwin
