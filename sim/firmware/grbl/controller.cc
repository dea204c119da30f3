#include "sim/firmware/grbl/controller.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "sim/link/gcode.h"

namespace caltwin::grbl {
namespace {

constexpr std::size_t kLongestLine = 79;

/// With the origin where grbl has it: at the upper end of each axis.
Machine InGrblsCoordinates(const Machine& drawn) {
  Machine machine = drawn;
  for (AxisDrawing& axis : machine.axes) {
    axis.min_mm = -axis.travel_mm();
    axis.max_mm = 0;
  }
  return machine;
}

}  // namespace

Controller::Controller(const Machine& machine,
                       const Settings& believed,
                       Plant* plant,
                       Pace* pace,
                       const Motors& stands_steps)
    : machine_(InGrblsCoordinates(machine)),
      settings_(believed),
      memory_(machine_, believed),
      motion_(machine_, &settings_, plant),
      plant_(plant),
      pace_(pace) {
  settings_.backlash_mm.fill(0);  // It knows none.
  motion_.PowerUpAt(stands_steps);
  pace_->Show(stands_steps);
  TakeSettings();
  is_locked_ = memory_.Is(kHomingCycle);
  Publish();
}

void Controller::TakeSettings() {
  MotionLimits limits = motion_.limits();
  bool counts_anew = false;
  for (int i = 0; i < 3; ++i) {
    double& steps_per_mm = settings_.steps_per_mm[static_cast<std::size_t>(i)];
    counts_anew = counts_anew || steps_per_mm != memory_.Value(kStepsPerMm + i);
    steps_per_mm = memory_.Value(kStepsPerMm + i);
    limits.feed_mm_s[i] = FeedFromWord_mm_s(memory_.Value(kMaxRate + i));
    limits.acceleration_mm_s2[i] = memory_.Value(kAcceleration + i);
  }
  motion_.SetLimits(limits);
  // The steps stay what they are: where it believes to stand changes.
  if (counts_anew) motion_.KeepCounts();
}

Vec3<double> Controller::WorkOffset_mm(const Modal& modal) const {
  Vec3<double> offset_mm =
      memory_.workplaces_mm[static_cast<std::size_t>(modal.workplace)] + g92_mm_;
  offset_mm[2] += tool_length_mm_;
  return offset_mm;
}

Controller::Lines Controller::Execute(std::string_view line) {
  said_.clear();
  if (needs_reset_ || is_asleep_) return {};
  says_ok_ = true;
  begins_anew_ = false;
  try {
    const std::string stripped = Stripped(line);
    if (stripped.size() > kLongestLine) throw LineError(kLineTooLong);
    Obey(stripped);
    CheckMotion();
    if (says_ok_) said_.emplace_back("ok");
    if (is_asleep_) said_.emplace_back("[MSG:Sleeping]");
    if (begins_anew_) Begin();
  } catch (const LineError& error) {
    said_.emplace_back(error.what());
  }
  Publish();
  return std::exchange(said_, {});
}

void Controller::Obey(std::string_view line) {
  if (line.empty()) return;
  if (line.front() == '$') {
    // As fast as it goes, a move has been made by the time the next line comes.
    if (!pace_->is_timed()) motion_.Finish();
    return ObeySystem(line.substr(1));
  }
  if (is_locked_ || is_jogging()) throw LineError(kLocked);
  ObeyBlock(ReadBlock(line, modal_));
}

Controller::Lines Controller::GoOn() {
  is_performing_ = true;
  motion_.PerformOne();  // On the way it may obey lines.
  is_performing_ = false;
  said_.clear();
  CheckMotion();
  Publish();
  return std::exchange(said_, {});
}

void Controller::CheckMotion() {
  if (!motion_.alarm()) return;
  const std::string why = *motion_.alarm();
  says_ok_ = false;
  if (pace_->is_stopped()) return;  // The reset that stopped it says what there is.
  motion_.Acknowledge();
  said_.push_back(fmt::format("[MSG:{}]", why));
  LockUntilReset(Alarm::kHardLimit);
}

void Controller::Lock(Alarm alarm) {
  said_.push_back(fmt::format("ALARM:{}", static_cast<int>(alarm)));
  is_locked_ = true;
}

void Controller::LockUntilReset(Alarm alarm) {
  Lock(alarm);
  said_.emplace_back("[MSG:Reset to continue]");
  needs_reset_ = true;
  says_ok_ = false;
}

void Controller::Begin() {
  modal_ = Modal{};
  g92_mm_.setZero();
  tool_length_mm_ = 0;
  needs_reset_ = is_checking_ = is_asleep_ = false;
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    live_.is_homing = live_.is_jogging = false;
    feed_percent_ = rapid_percent_ = spindle_percent_ = 100;
    until_offset_ = 0;
  }
  pace_->Clear();
  said_.emplace_back("");
  said_.emplace_back("Grbl 1.1h ['$' for help]");
  if (is_locked_) {
    said_.emplace_back("[MSG:'$H'|'$X' to unlock]");
  } else {
    RunStartupLines();
  }
  Publish();
}

void Controller::RunStartupLines() {
  for (const std::string& line : memory_.startup_lines) {
    if (line.empty()) continue;
    std::string outcome = "ok";
    try {
      ObeyBlock(ReadBlock(line, modal_));
    } catch (const LineError& error) {
      outcome = error.what();
    }
    said_.push_back(fmt::format(">{}:{}", line, outcome));
  }
}

Controller::Lines Controller::SwitchOn() {
  said_.clear();
  motion_.DropQueue();
  motion_.Restart();
  is_locked_ = memory_.Is(kHomingCycle);
  probed_mm_.setZero();
  has_probed_ = false;
  Begin();
  return std::exchange(said_, {});
}

Controller::Lines Controller::Reset(bool in_motion) {
  said_.clear();
  bool was_homing = false;
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    was_homing = live_.is_homing;
  }
  motion_.DropQueue();
  motion_.Acknowledge();
  // Who wakes up does not know where it is.
  is_locked_ = is_locked_ || is_asleep_;
  if (in_motion) Lock(was_homing ? Alarm::kResetInHoming : Alarm::kResetInMotion);
  Begin();
  return std::exchange(said_, {});
}

bool Controller::TakesMeanwhile(std::string_view line) const {
  constexpr std::size_t kPlannerBlocks = 15;
  if (needs_reset_ || is_asleep_ || motion_.num_queued() >= kPlannerBlocks)
    return false;
  try {
    const std::string stripped = Stripped(line);
    const bool is_jog = stripped.starts_with("$J=");
    if (stripped.empty() || (stripped.front() == '$' && !is_jog)) return true;
    Block block = ReadBlock(std::string_view(stripped).substr(is_jog ? 3 : 0), modal_);
    // What waits for the moves before it, or may stop them, has to wait itself.
    const int motion = block.modal.motion;
    const bool moves = block.axis_command == Block::AxisCommand::kMotion;
    if (block.program >= 0 || block.non_modal == 4 || block.non_modal == 28 ||
        block.non_modal == 30 || (moves && motion != kRapid && motion != kLinear)) {
      return false;
    }
    return !moves || !IsBeyondLimits(TakeTarget_mm(&block));
  } catch (const LineError&) {
    return true;  // It is refused, at once.
  }
}

void Controller::EndJogs() {
  motion_.DropQueue();
  motion_.Acknowledge();
  pace_->Clear();
  Publish();
}

void Controller::Hold() {
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    const bool is_heard = !live_.is_locked && !live_.is_checking && !live_.is_asleep;
    if (!is_heard && !live_.is_homing) return;
  }
  pace_->Hold();
}

void Controller::Resume() {
  pace_->Resume();
}

bool Controller::is_jogging() const {
  const std::lock_guard<std::mutex> lock(live_mutex_);
  return live_.is_jogging;
}

bool Controller::InMotion() const {
  const bool is_held = pace_->is_held(), is_moving = pace_->is_moving();
  const std::lock_guard<std::mutex> lock(live_mutex_);
  return live_.is_homing || (!is_held && (is_moving || live_.waiting_moves > 0));
}

void Controller::Override(unsigned char byte) {
  constexpr int kLeast = 10, kMost = 200;
  const std::lock_guard<std::mutex> lock(live_mutex_);
  const auto change = [&](int* percent, unsigned char first) {
    constexpr std::array kBy = {0, 10, -10, 1, -1};
    const auto k = static_cast<std::size_t>(byte - first);
    *percent = k == 0 ? 100 : std::clamp(*percent + kBy.at(k), kLeast, kMost);
  };
  if (byte >= 0x90 && byte <= 0x94) change(&feed_percent_, 0x90);
  if (byte == 0x95) rapid_percent_ = 100;
  if (byte == 0x96) rapid_percent_ = 50;
  if (byte == 0x97) rapid_percent_ = 25;
  if (byte >= 0x99 && byte <= 0x9d) change(&spindle_percent_, 0x99);
  until_overrides_ = 0;
}

}  // namespace caltwin::grbl
