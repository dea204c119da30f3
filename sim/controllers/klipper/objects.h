#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <variant>
#include <vector>

#include "sim/controllers/klipper/step_queue.h"

namespace caltwin {
namespace klipper {

// What a host configures on the chip, each under a number of its own (an oid). They
// only hold state; Microcontroller acts.

struct Stepper {
  int motor_index = 0;  ///< On the board.
  StepQueue queue{};
  int sense = -1;  ///< Of steps queued from now on; the direction pin begins low.
  /// Stopped by a trigger: ignores steps until its clock is reset.
  bool is_frozen = false;
};

/// Stops steppers at once for any of several reasons.
struct TriggerSync {
  bool can_trigger = false;
  std::int64_t reason = 0;  ///< Of the last trigger.
  std::optional<Clock> report_at{};
  Clock report_ticks = 0;
  std::optional<Clock> expires_at{};
  std::int64_t expire_reason = 0;
  std::vector<int> steppers{};  ///< Their oids.
};

/// A pin that is sampled until it reads as awaited, `samples` times in a row.
struct Endstop {
  int pin = 0;
  bool is_homing = false;
  Clock next = 0;  ///< The first sample not yet looked at; after a hit, behind it.
  Clock sample_ticks = 0;
  std::int64_t samples = 1;
  Clock rest_ticks = 1;
  bool awaited = true;
  int sync = 0;  ///< Its oid.
  std::int64_t reason = 0;
  std::optional<Clock> hit{};  ///< The first sample that read as awaited.

  Clock confirmed_at() const { return *hit + (samples - 1) * sample_ticks; }
};

/// A pin that is set at given times and falls back, or stops the chip, when nobody
/// renews what it was set to.
struct Output {
  struct Change {
    Clock at = 0;
    std::int64_t value = 0;
  };
  bool is_pwm = false;
  std::int64_t value = 0, default_value = 0;
  Clock longest = 0;  ///< Away from its default; 0: for ever.
  std::deque<Change> changes{};
  std::optional<Clock> deadline{};

  std::optional<Clock> NextEvent() const;
};

struct AnalogIn {
  int pin = 0;
  std::optional<Clock> next{};
  Clock rest_ticks = 0;
  std::int64_t samples = 1;
  std::int64_t least = 0, most = 0xFFFF;
  std::int64_t allowed_outside = 0;  ///< Readings in a row; 0: any number.
  std::int64_t outside = 0;
};

struct Buttons {
  std::vector<int> pins{};
  std::optional<Clock> next{};
  Clock rest_ticks = 0;
  std::uint8_t invert = 0;
  std::int64_t retransmit = 1;  ///< Every so many polls what was not acknowledged.
  std::int64_t polls_to_send = 0;
  std::int64_t acknowledged = 0;
  std::uint8_t last = 0;
  std::vector<std::uint8_t> states{};  ///< Not acknowledged.
};

using Object = std::
    variant<std::monostate, Stepper, TriggerSync, Endstop, Output, AnalogIn, Buttons>;

/// When it acts next by itself; an endstop only once it was hit.
std::optional<Clock> NextEventOf(const Object& object);

}  // namespace klipper
}  // namespace caltwin
