#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/controllers/board.h"

namespace caltwin {
namespace linuxcnc {

/// How the probe's contact reaches LinuxCNC.
struct ProbeInput {
  /// The card holds where the joints stood when it closed, and reports that as their
  /// place in the cycle that sees it: what G38 records is then no cycle late.
  bool is_latched = false;
  /// For so long after it has closed it opens and closes in turns, once a cycle [s].
  double bounce_s = 0;
};

/// A board under LinuxCNC: joint N is its Nth motor, the pin of that motor's name with
/// _STOP its switch, PROBE the probe. Once a servo cycle every joint is told where to
/// be next; its step generator goes there in a straight line, by whole steps.
///
/// A probe's chance is drawn anew once it has been open for 20 cycles.
class Joints {
 public:
  explicit Joints(Board* board, const ProbeInput& probe = {});

  int size() const { return board_->num_motors(); }

  struct Inputs {
    std::uint32_t switches = 0;  ///< A bit a joint.
    bool probe = false;
    /// Where the motors are reported to be, with the fraction that is not stepped yet.
    Motors reported_steps{};
  };
  /// What the inputs show at the end of a cycle in which the motors went to
  /// `commanded_steps`, fractions of steps allowed. `now_s`: LinuxCNC's time.
  Inputs Cycle(const Motors& commanded_steps, double now_s = 0);
  const Inputs& inputs() const { return inputs_; }

  /// Where the motors stand, whole steps as the board counts them.
  const Motors& steps() const { return steps_; }

 private:
  Inputs Read();
  void DrawChance();
  /// On the straight way there: the first place at which the probe acts, to a
  /// thousandth of the way.
  Motors Tripped(const Motors& from, const Motors& to);
  /// What the contact shows while it bounces.
  bool Bounced(bool has_met, double now_s);

  Board* board_;
  std::vector<std::optional<int>> switches_{};  ///< Pins, by joint.
  std::optional<int> probe_{};
  Motors steps_;
  Inputs inputs_{};
  ProbeInput input_;
  Motors commanded_;
  int open_cycles_ = 0;
  bool is_drawn_ = false;
  bool has_met_ = false, is_shown_ = false;  ///< In the last cycle.
  double met_s_ = 0;                         ///< When it closed last.
};

}  // namespace linuxcnc
}  // namespace caltwin
