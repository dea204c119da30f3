#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/firmware/backlash.h"
#include "sim/firmware/planner.h"
#include "sim/firmware/plant.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// The part of the firmware that turns coordinates into motor steps and drives the
/// plant: whole steps, backlash compensation, queue, homing, probe moves.
///
/// Three positions are told apart: *commanded* [mm], what G-code asked of an axis;
/// *count*, the whole steps of its drive nearest to it, from machine zero; and the
/// *motor*, count plus the backlash steps applied plus where machine zero lies in the
/// plant's steps. Where drives move the axes together (CoreXY), counts and settings are
/// the drives', as RepRapFirmware has it: X stands for the first of them. Where several
/// motors carry z, all go as its count does, each so much beside it as it was moved
/// singly; each has a switch of its own and homes to it.
class Motion {
 public:
  /// `settings` and `plant` are borrowed; steps per mm and backlash are read from
  /// `settings` whenever a move is made.
  Motion(const Machine& machine, const Settings* settings, Plant* plant);

  /// Queues a straight move to machine coordinates [mm]; performs older ones where the
  /// queue is full. Limits and homing are the caller's to check.
  void MoveTo(const Vec3<double>& target_mm, double feed_mm_s);
  /// Performs what is queued; the machine then stands.
  void Finish();
  void Dwell(double s);

  /// Performs the first of what is queued, if anything is.
  void PerformOne();
  bool has_queued() const { return !queue_.empty(); }
  std::size_t num_queued() const { return queue_.size(); }

  struct Probed {
    bool stopped = false;  ///< By what was watched for.
    /// Where whole steps had the axes then; not stopped: at the end.
    Vec3<double> at_mm = Vec3<double>::Zero();
  };
  /// What a controller does at the probe's word.
  enum class AtTrigger {
    kStands,  ///< The motors stop on the step that they are at (RepRapFirmware).
    kBrakes   ///< It notes the place and brakes at the axes' acceleration (grbl).
  };
  /// A move that the probe ends; stands still before and after.
  Probed Probe(const Vec3<double>& target_mm,
               double feed_mm_s,
               Watch::Kind kind,
               AtTrigger then = AtTrigger::kStands);
  /// How an axis looks for its switch: fast to it, back, slowly again, and away.
  struct Homing {
    double fast_mm_s = 20;
    double slow_mm_s = 2;
    double back_off_mm = 5;
    double pull_off_mm = 0;  ///< How far it leaves the switch when all is done.
  };
  /// At the switch, met slowly, the position is the drawing's end. False where the
  /// switch never closed.
  bool Home(Axis axis, const Homing& homing);
  bool Home(Axis axis) { return Home(axis, Homing{}); }
  /// How many motors carry z.
  std::size_t num_z_motors() const { return motors_.size() - 2; }
  /// Each of z's motors beside z's own position.
  Vec3<double> beside_mm() const;
  /// Each of z's motors at z = 0, without backlash steps.
  Vec3<double> z_zero_steps() const;
  /// From now on z is where the first of its motors is.
  void FollowFirst();
  /// Moves each of z's motors by so much along z; the position of z stays what it was.
  void MoveSingly(const Motors& by_mm, double feed_mm_s);
  /// Declares where the axis stands (G92, homing): counts follow, backlash is cleared.
  void SetPosition(Axis axis, double mm);
  /// After a change of steps per mm: the position stays, the counts follow.
  void KeepPosition();
  /// The same for a controller that keeps its steps: the position follows (grbl).
  void KeepCounts();
  /// After M400 and G4: the commanded position is recomputed from the counts. With the
  /// defect before 3.6.1 the backlash steps applied are taken for travel.
  void Recompute(bool ignores_backlash);
  /// As after power-up: not homed, position 0 wherever the machine stands.
  void Restart();
  /// The same, where the motors are known to stand so.
  void PowerUpAt(const Motors& steps);
  /// Drops the queue where it stands.
  void DropQueue();
  /// The same (M112); nothing is homed any more.
  void Abandon();
  /// What stopped the machine is over; where it is counted to stand stays.
  void Acknowledge() { alarm_.reset(); }

  bool is_homed(Axis axis) const { return is_homed_[Index(axis)]; }
  void Unhome(Axis axis) { is_homed_[Index(axis)] = false; }
  /// What stopped the machine for good, until Restart.
  const std::optional<std::string>& alarm() const { return alarm_; }
  double time_s() const { return time_s_; }
  const MotionLimits& limits() const { return limits_; }
  /// For moves from now on; what is queued is performed first.
  void SetLimits(const MotionLimits& limits);
  /// How much longer than a backlash correction a move must be to take all of it.
  void set_backlash_factor(double factor) { backlash_factor_ = factor; }
  double backlash_factor() const { return backlash_factor_; }

  /// @name At the end of the queue
  Vec3<double> commanded_mm() const;
  /// @name Of what has been performed
  const Vec3<double>& counts() const { return counts_done_; }
  /// Where whole steps, divided by steps per mm, have the axes.
  Vec3<double> counted_mm() const;
  const Motors& motor_steps() const { return motors_done_; }
  Vec3<double> senses() const;

 private:
  struct DriveState {
    std::int64_t count = 0;
    std::int64_t zero = 0;  ///< Motor steps at count 0 without backlash steps.
    BacklashCompensation backlash{};
    std::int64_t motor() const { return zero + count + backlash.applied_steps(); }
  };
  /// One motor, of a drive that may have several.
  struct Motor {
    int drive = 0;
    std::int64_t beside_steps = 0;  ///< What it was moved singly.
    double rest_steps = 0;          ///< Of a step, not yet made.
  };
  /// Steps of one move, by drive.
  struct StepPlan {
    std::array<std::int64_t, 3> by_steps{};
    std::array<std::int64_t, 3> backlash{};
    Segment segment{};
    Vec3<double> delta_mm = Vec3<double>::Zero();  ///< Of the axes.
    bool is_empty = true;
  };
  StepPlan PlanSteps(const Vec3<double>& target_mm);
  void PerformFirst();
  /// How a move that was made alone ended, and how fast it then went.
  struct Ended {
    Outcome outcome{};
    double feed_mm_s = 0;
  };
  /// One move from rest to rest, or to the stop; the queue is empty.
  Ended RunAlone(const Vec3<double>& target_mm, double feed_mm_s, const Watch& watch);
  /// One move that nothing is to end; whether nothing did.
  bool RunWhole(const Vec3<double>& target_mm, double feed_mm_s);
  /// Brakes from a feed, in a direction.
  void Brake(const Vec3<double>& along, double feed_mm_s);
  /// The motors stand on whole steps where a move was left; the queue is dropped.
  void StandAt(const Segment& segment, double time_s);
  void AccountForStop(const StepPlan& plan,
                      const Segment& done,
                      const Outcome& outcome);
  void RaiseAlarm(const std::string& words, const Segment& segment, double time_s);
  bool RunToSwitch(Axis axis, double travel_mm, double feed_mm_s);
  void NoteDone();
  void ForgetRests();
  Motors MotorsNow() const;
  /// What is left of where a motor stands once its drive is counted.
  void NoteBeside(const Motors& whole_steps);
  /// Where these counts have the axes.
  Vec3<double> AxesAt_mm(const Vec3<double>& counts) const;
  Vec3<double> counts_now() const;
  std::int64_t CountAt(int drive, const Vec3<double>& axes_mm) const;
  /// Whether that drive moves that axis.
  bool Moves(int drive, Axis axis) const;

  const Settings* settings_;
  Plant* plant_;
  std::array<AxisDrawing, 3> drawings_;
  const DriveMap* drives_;  ///< Null: each axis has its own.
  MotionLimits limits_{};
  std::array<DriveState, 3> states_{};
  /// In the plant's order: the first of each drive, then z's others.
  std::vector<Motor> motors_;
  Vec3<double> commanded_mm_ = Vec3<double>::Zero();
  std::array<bool, 3> is_homed_{};
  MoveQueue queue_;
  std::deque<Vec3<double>> counts_queued_{};  ///< At the end of each queued move.
  Vec3<double> counts_done_ = Vec3<double>::Zero();
  Motors motors_done_{};
  double time_s_ = 0;
  double backlash_factor_ = 10;
  std::optional<std::string> alarm_{};
};

}  // namespace caltwin
