#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/controllers/board.h"

namespace caltwin {
namespace linuxcnc {

/// A board under LinuxCNC: joint N is its Nth motor, the pin of that motor's name with
/// _STOP its switch, PROBE the probe. Once a servo cycle every joint is told where to
/// be next; its step generator goes there in a straight line, by whole steps.
///
/// A probe's chance is drawn anew once it has been open for 20 cycles.
class Joints {
 public:
  explicit Joints(Board* board);

  int size() const { return board_->num_motors(); }

  struct Inputs {
    std::uint32_t switches = 0;  ///< A bit a joint.
    bool probe = false;
  };
  /// What the inputs show at the end of a cycle in which the motors went to
  /// `commanded_steps`, fractions of steps allowed.
  Inputs Cycle(const Motors& commanded_steps);
  const Inputs& inputs() const { return inputs_; }

  /// Where the motors stand, whole steps as the board counts them.
  const Motors& steps() const { return steps_; }

 private:
  Inputs Read();
  void DrawChance();

  Board* board_;
  std::vector<std::optional<int>> switches_{};  ///< Pins, by joint.
  std::optional<int> probe_{};
  Motors steps_;
  Inputs inputs_{};
  int open_cycles_ = 0;
  bool is_drawn_ = false;
};

}  // namespace linuxcnc
}  // namespace caltwin
