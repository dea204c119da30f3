#include "sim/firmware/pace.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace caltwin {
namespace {

using std::chrono::duration;
using std::chrono::duration_cast;

constexpr double kLongest_s = 1e7;  // Of one move: nobody waits that long.
constexpr std::chrono::milliseconds kGlance(20);  // Between two looks at a timed move.
/// What computing took is made good in the next move, up to so much.
constexpr std::chrono::milliseconds kMadeGood(500);

/// The beginning of a move, as far as it gets in that time.
Segment Beginning(const Segment& whole, double gone_s) {
  Segment part = whole;
  part.to_steps = whole.Steps(gone_s);
  part.profile.length_mm = whole.profile.Distance_mm(gone_s);
  part.profile.feed_out_mm_s = whole.profile.Feed_mm_s(gone_s);
  // Whether it still gathers way or brakes already, its feed then is the most or the
  // least of what is left.
  const double to_top_s = (whole.profile.feed_top_mm_s - whole.profile.feed_in_mm_s) /
                          whole.profile.acceleration_mm_s2;
  if (gone_s < to_top_s) part.profile.feed_top_mm_s = part.profile.feed_out_mm_s;
  return part;
}

}  // namespace

Pace::Pace(double speed) : speed_(speed), is_timed_(std::isfinite(speed)) {}

void Pace::Hold() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_held_ = true;
  changed_.notify_all();
}

void Pace::Resume() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_held_ = false;
  changed_.notify_all();
}

void Pace::Stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}

void Pace::StopForGood() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_over_ = true;
  is_stopped_ = true;
  changed_.notify_all();
}

void Pace::Clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_stopped_ = is_over_;
  is_held_ = false;
}

bool Pace::is_held() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_held_;
}

bool Pace::is_stopped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_stopped_;
}

bool Pace::is_moving() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_moving_;
}

double Pace::feed_mm_s() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_moving_ && !is_held_ ? feed_mm_s_ : 0;
}

Motors Pace::steps() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return steps_;
}

void Pace::Show(const Motors& steps) {
  const std::lock_guard<std::mutex> lock(mutex_);
  steps_ = steps;
  is_moving_ = false;
}

bool Pace::WaitWhileHeld() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return !is_held_ || is_stopped_; });
  return !is_stopped_;
}

double Pace::Play(double duration_s, const std::function<void(double)>& show) {
  if (!WaitWhileHeld()) return 0;
  if (!is_timed_) {
    show(duration_s);
    return duration_s;
  }
  Clock::time_point begin =
      Clock::now() - std::min<Clock::duration>(std::exchange(late_, {}), kMadeGood);
  const auto whole = duration_cast<Clock::duration>(
      duration<double>(std::min(duration_s / speed_, kLongest_s)));
  while (Clock::now() < begin + whole) {
    const duration<double> passed = Clock::now() - begin;
    const double gone_s = std::clamp(passed.count() * speed_, 0.0, duration_s);
    show(gone_s);
    std::unique_lock<std::mutex> lock(mutex_);
    if (is_stopped_) return gone_s;
    if (is_held_) {
      const Clock::time_point since = Clock::now();
      changed_.wait(lock, [&] { return !is_held_ || is_stopped_; });
      begin += Clock::now() - since;
      continue;
    }
    changed_.wait_until(lock, std::min(begin + whole, Clock::now() + kGlance));
  }
  show(duration_s);
  return duration_s;
}

double PacedPlant::Play(const Segment& segment, double until_s, bool is_plain) {
  return pace_->Play(until_s, [&](double gone_s) {
    if (is_plain && pace_->meanwhile_ && gone_s < until_s) pace_->meanwhile_();
    const Motors steps = segment.Steps(gone_s);
    const double feed_mm_s = segment.profile.Feed_mm_s(gone_s);
    const std::lock_guard<std::mutex> lock(pace_->mutex_);
    pace_->steps_ = steps;
    pace_->feed_mm_s_ = feed_mm_s;
    pace_->is_moving_ = true;
  });
}

Outcome PacedPlant::Compute(const Segment& segment, const Watch& watch) {
  const Pace::Clock::time_point begin = Pace::Clock::now();
  const Outcome outcome = plant_->Run(segment, watch);
  pace_->late_ += Pace::Clock::now() - begin;
  return outcome;
}

Outcome PacedPlant::RunPlain(const Segment& segment) {
  const double duration_s = segment.profile.Duration_s();
  const double gone_s = Play(segment, duration_s, /*is_plain=*/true);
  if (gone_s >= duration_s) return Compute(segment, Watch{});
  if (segment.profile.Distance_mm(gone_s) <= 0) return {.stopped = true};
  Outcome outcome = Compute(Beginning(segment, gone_s), Watch{});
  outcome.stopped = true;
  if (!outcome.alarm) outcome.time_s = gone_s;
  return outcome;
}

Outcome PacedPlant::Run(const Segment& segment, const Watch& watch) {
  Outcome outcome;
  if (watch.kind == Watch::Kind::kNothing) {
    outcome = RunPlain(segment);
  } else if (pace_->WaitWhileHeld()) {
    outcome = Compute(segment, watch);
    if (Play(segment, outcome.time_s, /*is_plain=*/false) < outcome.time_s)
      outcome.alarm = "stopped";
  } else {
    outcome = {.alarm = "stopped"};
  }
  pace_->Show(segment.Steps(outcome.time_s));
  return outcome;
}

void PacedPlant::Settle(const Motors& steps) {
  plant_->Settle(steps);
  pace_->Show(steps);
}

void PacedPlant::Dwell(double s) {
  plant_->Dwell(pace_->Play(s, [](double) {}));
}

}  // namespace caltwin
