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

Joints::Joints(Board* board, const ProbeInput& probe)
    : board_(board),
      switches_(static_cast<std::size_t>(board->num_motors())),
      probe_(PinOf(*board, "PROBE")),
      steps_(Motors::Zero(board->num_motors())),
      input_(probe),
      commanded_(steps_) {
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

Motors Joints::Tripped(const Motors& from, const Motors& to) {
  constexpr int kHalvings = 10;
  double before = 0, after = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (before + after) / 2;
    Motors at = from + middle * (to - from);
    for (double& steps : at) steps = std::round(steps);
    (board_->IsHigh(*probe_, at) ? after : before) = middle;
  }
  return from + after * (to - from);
}

bool Joints::Bounced(bool has_met, double now_s) {
  if (has_met && !has_met_) met_s_ = now_s;
  const bool is_new = has_met && !has_met_;
  has_met_ = has_met;
  const bool bounces = has_met && !is_new && now_s - met_s_ <= input_.bounce_s;
  is_shown_ = bounces ? !is_shown_ : has_met;
  return is_shown_;
}

Joints::Inputs Joints::Cycle(const Motors& commanded_steps, double now_s) {
  Motors to = commanded_steps;
  for (double& steps : to) steps = std::round(steps);
  const bool was_open = !inputs_.probe;
  Motors reported = commanded_steps;
  if (to != steps_) {
    // Asked before they are followed to: on the way chance and play are as they were.
    if (input_.is_latched && was_open && probe_ && board_->IsHigh(*probe_, to)) {
      reported = Tripped(commanded_, commanded_steps);
    }
    board_->Follow(to);
    steps_ = to;
    inputs_ = Read();
  }
  commanded_ = commanded_steps;
  open_cycles_ = inputs_.probe ? 0 : open_cycles_ + 1;
  if (inputs_.probe) is_drawn_ = false;
  if (!is_drawn_ && open_cycles_ >= kSettledCycles) DrawChance();
  Inputs shown = inputs_;
  shown.reported_steps = reported;
  if (input_.bounce_s > 0) shown.probe = Bounced(inputs_.probe, now_s);
  return shown;
}

}  // namespace linuxcnc
}  // namespace caltwin
