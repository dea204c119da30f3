#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/require.h"
#include "sim/controllers/klipper/microcontroller.h"

namespace caltwin {
namespace klipper {

/// One motor, a switch that reads high from `closes_at` steps on, a pin of half the
/// reference voltage.
class ToyBoard : public Board {
 public:
  std::span<const std::string> pins() const override { return pins_; }
  int num_motors() const override { return 1; }
  std::optional<int> MotorAt(int pin) const override {
    return pin == 0 ? std::optional(0) : std::nullopt;
  }
  bool IsHigh(int /*pin*/, const Motors& steps) override {
    return steps[0] >= closes_at && steps[0] < opens_at;
  }
  double Analog(int /*pin*/) const override { return 0.5; }
  void Arm(int /*pin*/) override { ++armed; }
  void Follow(const Motors& steps) override { at = steps[0]; }

  double closes_at = 100, opens_at = 1e9, at = 0;
  int armed = 0;

 private:
  std::vector<std::string> pins_{"STEP", "DIR", "SWITCH", "TH"};
};

/// The other end of the line: sends commands by name, keeps what is answered.
class ToyHost {
 public:
  explicit ToyHost(Microcontroller* chip) : chip_(chip) {}

  /// Sends a command in a block of its own; takes what has been said.
  void Send(std::string_view name, const std::vector<Argument>& arguments = {}) {
    const auto all = Commands();
    const auto found = std::ranges::find(all, name, &MessageFormat::name);
    Require(found != all.end(), name);
    Bytes payload;
    AppendMessage(*found, arguments, &payload);
    chip_->Receive(BlockOf(sequence_++, payload));
    Hear();
  }
  void At(Clock clock) {
    chip_->Advance(clock);
    Hear();
  }
  /// The responses of that name so far, each the numbers that it had.
  std::vector<std::vector<std::int64_t>> Said(std::string_view name) const {
    std::vector<std::vector<std::int64_t>> said;
    for (const auto& one : heard_) {
      if (one.name == name) said.push_back(one.numbers);
    }
    return said;
  }
  int num_acknowledged() const { return num_acknowledged_; }

 private:
  struct Heard {
    std::string name{};
    std::vector<std::int64_t> numbers{};
  };

  void Hear() {
    reader_.Feed(chip_->TakeOutput());
    while (const auto received = reader_.Take()) {
      Require(received->is_sound, "the chip sends sound blocks");
      if (received->payload.empty()) {
        ++num_acknowledged_;
      } else {
        Note(received->payload);
      }
    }
  }
  void Note(ByteView payload) {
    const auto id = TakeVlq(&payload);
    const auto all = Responses();
    const auto format = std::ranges::find(all, *id, &MessageFormat::id);
    Require(format != all.end(), "a response of that number");
    Heard heard{.name = std::string(format->name)};
    for (const Parameter& parameter : format->parameters) {
      if (parameter.is_bytes) {
        payload = payload.subspan(1 + payload[0]);
      } else {
        const std::int64_t number = *TakeVlq(&payload);
        heard.numbers.push_back(
            parameter.is_signed ? number : static_cast<std::uint32_t>(number));
      }
    }
    heard_.push_back(heard);
  }

  Microcontroller* chip_;
  BlockReader reader_{};
  int sequence_ = 1;
  std::vector<Heard> heard_{};
  int num_acknowledged_ = 0;
};

}  // namespace klipper
}  // namespace caltwin
