#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <limits>
#include <mutex>
#include <utility>

#include "sim/firmware/plant.h"

namespace caltwin {

/// How fast a served machine's time goes, and the hands that hold or stop it: what the
/// thread that performs moves shares with those that listen to clients.
///
/// Timed, a move is shown as it goes on: steps() follows it. Not timed, a move is over
/// as soon as it is computed.
class Pace {
 public:
  /// `speed`: seconds of the machine in one of ours; infinite: as fast as it goes.
  explicit Pace(double speed = std::numeric_limits<double>::infinity());

  bool is_timed() const { return is_timed_; }

  /// @name From any thread
  /// No further move begins, and a timed one stands where it is, until Resume. Unlike a
  /// real machine it neither brakes nor gathers way.
  void Hold();
  void Resume();
  bool is_held() const;
  /// Ends the move being performed where it is, and all that follow, until Clear.
  void Stop();
  /// The same, and Clear does not end it.
  void StopForGood();
  bool is_stopped() const;
  /// Whether a move is on its way, and how fast it goes.
  bool is_moving() const;
  double feed_mm_s() const;
  /// Where the motors stand.
  Motors steps() const;

  /// @name From the thread that performs moves
  void Clear();
  /// Called while a plain move goes on, every 20 ms or oftener: what its controller
  /// does besides. It may add moves and must perform none.
  void SetMeanwhile(std::function<void()> meanwhile) {
    meanwhile_ = std::move(meanwhile);
  }
  /// Where the motors stand while nothing moves.
  void Show(const Motors& steps);
  /// Lets so much of the machine's time pass, `show` called on the way with the part
  /// that has. Returns how much it was: less after Stop.
  double Play(double duration_s, const std::function<void(double gone_s)>& show);
  /// Returns once nobody holds; false: stopped instead.
  bool WaitWhileHeld();

 private:
  friend class PacedPlant;
  using Clock = std::chrono::steady_clock;

  double speed_;
  bool is_timed_;
  mutable std::mutex mutex_{};
  std::condition_variable changed_{};
  bool is_held_ = false;
  bool is_stopped_ = false;
  bool is_over_ = false;
  bool is_moving_ = false;
  double feed_mm_s_ = 0;
  Motors steps_ = Motors::Zero(3);
  std::function<void()> meanwhile_{};
  Clock::duration late_{};  ///< What computing took, not yet made good.
};

/// A plant whose moves keep a pace. A plain move is performed once its time has passed,
/// or as much of it as had when it was stopped (its Outcome says `stopped`). A move
/// that looks for something is performed first, since only then is known how long it
/// takes; stopped, it ends in an alarm.
class PacedPlant final : public Plant {
 public:
  /// Both are borrowed.
  PacedPlant(Plant* plant, Pace* pace) : plant_(plant), pace_(pace) {}

  Outcome Run(const Segment& segment, const Watch& watch) override;
  void Settle(const Motors& steps) override;
  void Dwell(double s) override;
  bool ProbeTriggered() override { return plant_->ProbeTriggered(); }
  bool SwitchClosed(Axis axis) override { return plant_->SwitchClosed(axis); }

 private:
  Outcome Compute(const Segment& segment, const Watch& watch);
  Outcome RunPlain(const Segment& segment);
  double Play(const Segment& segment, double until_s, bool is_plain);

  Plant* plant_;
  Pace* pace_;
};

}  // namespace caltwin
