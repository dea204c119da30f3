#include <algorithm>
#include <utility>

#include "sim/controllers/klipper/microcontroller.h"

namespace caltwin {
namespace klipper {

void Microcontroller::AddOutput(const Message& message, bool is_pwm) {
  if (!PinOf(message, "pin")) return;
  Output output{.is_pwm = is_pwm,
                .value = message["value"],
                .default_value = message["default_value"],
                .longest = message["max_duration"]};
  if (output.longest > 0 && output.value != output.default_value) {
    output.deadline = now_ + output.longest;
  }
  Add(message, output);
}

void Microcontroller::ConfigDigitalOut(const Message& message) {
  AddOutput(message, /*is_pwm=*/false);
}

void Microcontroller::ConfigPwmOut(const Message& message) {
  AddOutput(message, /*is_pwm=*/true);
}

void Microcontroller::QueueChange(const Message& message, std::string_view value) {
  auto* const output = Find<Output>(message);
  if (output == nullptr) return;
  if (NumMovesWaiting() >= kMoveCount) return ShutDown("Move queue overflow");
  if (const auto clock = TimeOf(message)) {
    output->changes.push_back({.at = *clock, .value = message[value]});
  }
}

void Microcontroller::QueueDigitalOut(const Message& message) {
  QueueChange(message, "on_ticks");
}

void Microcontroller::QueuePwmOut(const Message& message) {
  QueueChange(message, "value");
}

void Microcontroller::SetDigitalOutPwmCycle(const Message& message) {
  Find<Output>(message);
}

void Microcontroller::UpdateDigitalOut(const Message& message) {
  auto* const output = Find<Output>(message);
  if (output == nullptr) return;
  output->changes.assign(1, {.at = now_, .value = message["value"]});
  Fire(static_cast<int>(message["oid"]), output);
}

void Microcontroller::SetDigitalOut(const Message& message) {
  PinOf(message, "pin");
}

void Microcontroller::ConfigAnalogIn(const Message& message) {
  if (const auto pin = PinOf(message, "pin")) Add(message, AnalogIn{.pin = *pin});
}

void Microcontroller::QueryAnalogIn(const Message& message) {
  auto* const analog = Find<AnalogIn>(message);
  if (analog == nullptr) return;
  analog->next.reset();
  if (message["sample_count"] == 0) return;
  const auto clock = TimeOf(message);
  if (!clock) return;
  *analog = {.pin = analog->pin,
             .next = clock,
             .rest_ticks = std::max(message["rest_ticks"], kFastest),
             .samples = message["sample_count"],
             .least = message["min_value"],
             .most = message["max_value"],
             .allowed_outside = message["range_check_count"]};
}

void Microcontroller::ConfigButtons(const Message& message) {
  constexpr std::int64_t kMostButtons = 8;
  const std::int64_t count = message["button_count"];
  if (count > kMostButtons) return ShutDown("Invalid count parameter");
  Add(message, Buttons{.pins = std::vector<int>(static_cast<std::size_t>(count), 0)});
}

void Microcontroller::ButtonsAdd(const Message& message) {
  auto* const buttons = Find<Buttons>(message);
  const auto pin = PinOf(message, "pin");
  if (buttons == nullptr || !pin) return;
  const auto at = static_cast<std::size_t>(message["pos"]);
  if (at >= buttons->pins.size()) return ShutDown("Invalid count parameter");
  buttons->pins[at] = *pin;
}

void Microcontroller::ButtonsQuery(const Message& message) {
  auto* const buttons = Find<Buttons>(message);
  if (buttons == nullptr) return;
  const auto clock = TimeOf(message);
  if (!clock) return;
  *buttons = {.pins = buttons->pins,
              .next = message["rest_ticks"] == 0 ? std::nullopt : clock,
              .rest_ticks = std::max(message["rest_ticks"], kFastest),
              .invert = static_cast<std::uint8_t>(message["invert"]),
              .retransmit = message["retransmit_count"]};
}

void Microcontroller::ButtonsAck(const Message& message) {
  auto* const buttons = Find<Buttons>(message);
  if (buttons == nullptr) return;
  const auto count =
      std::min(static_cast<std::size_t>(message["count"]), buttons->states.size());
  buttons->acknowledged = (buttons->acknowledged + message["count"]) % 256;
  buttons->states.erase(buttons->states.begin(),
                        buttons->states.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace klipper
}  // namespace caltwin
