#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/controllers/board.h"

namespace caltwin {
namespace linuxcnc {

/// Two motors, U with a switch that closes at -100 steps and V with none; the probe
/// acts where U is at `probe_at` steps or beyond.
class FakeBoard final : public Board {
 public:
  double probe_at = 50;
  int num_armed = 0;
  std::vector<Motors> followed{};

  std::span<const std::string> pins() const override { return pins_; }
  int num_motors() const override { return 2; }
  std::optional<int> MotorAt(int pin) const override {
    if (pin == 0) return 0;
    if (pin == 2) return 1;
    return std::nullopt;
  }
  bool IsHigh(int pin, const Motors& steps) override {
    return pin == 4 ? steps[0] <= -100 : pin == 5 && steps[0] >= probe_at;
  }
  double Analog(int /*pin*/) const override { return 0; }
  void Arm(int /*pin*/) override { ++num_armed; }
  void Follow(const Motors& steps) override { followed.push_back(steps); }

 private:
  std::vector<std::string> pins_ = {
      "U_STEP", "U_DIR", "V_STEP", "V_DIR", "U_STOP", "PROBE"};
};

inline Motors Both(double u, double v) {
  Motors steps(2);
  steps << u, v;
  return steps;
}

}  // namespace linuxcnc
}  // namespace caltwin
