#include "sim/controllers/linuxcnc/joints.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

namespace caltwin {
namespace linuxcnc {
namespace {

constexpr std::string_view kStepPin = "_STEP";
constexpr int kSettledCycles = 20;

std::optional<int> PinOf(const Board& board, std::string_view name) {
  const auto pins = board.pins();
  const auto found = std::ranges::find(pins, name);
  if (found == pins.end()) return std::nullopt;
  return static_cast<int>(found - pins.begin());
}

}  // namespace

Joints::Joints(Board* board)
    : board_(board),
      switches_(static_cast<std::size_t>(board->num_motors())),
      probe_(PinOf(*board, "PROBE")),
      steps_(Motors::Zero(board->num_motors())) {
  const auto pins = board->pins();
  for (std::size_t pin = 0; pin < pins.size(); ++pin) {
    const auto motor = board->MotorAt(static_cast<int>(pin));
    if (!motor) continue;
    const std::string name = pins[pin].substr(0, pins[pin].size() - kStepPin.size());
    switches_[static_cast<std::size_t>(*motor)] = PinOf(*board, name + "_STOP");
  }
  DrawChance();
  inputs_ = Read();
}

Joints::Inputs Joints::Read() {
  Inputs inputs;
  for (std::size_t i = 0; i < switches_.size(); ++i) {
    const auto& pin = switches_[i];
    if (pin && board_->IsHigh(*pin, steps_)) inputs.switches |= 1U << i;
  }
  inputs.probe = probe_ && board_->IsHigh(*probe_, steps_);
  return inputs;
}

void Joints::DrawChance() {
  if (probe_) board_->Arm(*probe_);
  is_drawn_ = true;
}

Joints::Inputs Joints::Cycle(const Motors& commanded_steps) {
  Motors to = commanded_steps;
  for (double& steps : to) steps = std::round(steps);
  if (to != steps_) {
    board_->Follow(to);
    steps_ = to;
    inputs_ = Read();
  }
  open_cycles_ = inputs_.probe ? 0 : open_cycles_ + 1;
  if (inputs_.probe) is_drawn_ = false;
  if (!is_drawn_ && open_cycles_ >= kSettledCycles) DrawChance();
  return inputs_;
}

}  // namespace linuxcnc
}  // namespace caltwin
