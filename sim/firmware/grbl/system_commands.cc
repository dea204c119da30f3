// Lines that begin with $.

#include <string>

#include <fmt/format.h>

#include "sim/firmware/grbl/controller.h"
#include "sim/link/gcode.h"

namespace caltwin::grbl {
namespace {

constexpr std::string_view kHelp =
    "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]";

}  // namespace

void Controller::RequireIdle() const {
  if (is_performing_ || motion_.has_queued() || is_jogging()) throw LineError(kNotIdle);
}

void Controller::ObeySystem(std::string_view line) {
  if (line.empty()) {
    said_.emplace_back(kHelp);
  } else if (line == "G") {
    said_.push_back(ModalLine());
  } else if (line == "X") {
    if (is_locked_) said_.emplace_back("[MSG:Caution: Unlocked]");
    is_locked_ = false;
  } else if (line.starts_with("J=")) {
    Jog(line.substr(2));
  } else {
    RequireIdle();
    const bool only_tells = line == "$" || line == "#" || line == "I" || line == "N";
    if (is_checking_ && !only_tells && line != "C") throw LineError(kNotIdle);
    ObeyIdle(line);
  }
}

void Controller::ObeyIdle(std::string_view line) {
  if (line == "$") {
    for (std::string& setting : memory_.Lines()) said_.push_back(std::move(setting));
  } else if (line == "#") {
    for (std::string& place : ParameterLines()) said_.push_back(std::move(place));
  } else if (line == "I") {
    said_.push_back(fmt::format("[VER:1.1h.20190830:{}]", memory_.build_text));
    said_.emplace_back("[OPT:V,15,128]");
  } else if (line == "N") {
    for (std::size_t i = 0; i < memory_.startup_lines.size(); ++i) {
      said_.push_back(fmt::format("$N{}={}", i, memory_.startup_lines[i]));
    }
  } else if (line == "H") {
    Home();
  } else if (line == "C") {
    SwitchChecking();
  } else if (line == "SLP") {
    is_asleep_ = true;
  } else {
    ObeyAssignment(line);
  }
}

void Controller::SwitchChecking() {
  if (is_checking_) {
    said_.emplace_back("[MSG:Disabled]");
    begins_anew_ = true;
    return;
  }
  if (is_locked_) throw LineError(kNotIdle);
  checked_mm_ = motion_.commanded_mm();
  is_checking_ = true;
  said_.emplace_back("[MSG:Enabled]");
}

void Controller::ObeyAssignment(std::string_view line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) throw LineError(kInvalidStatement);
  const std::string_view name = line.substr(0, equals);
  const std::string_view value = line.substr(equals + 1);
  if (name == "RST") return Restore(value);
  if (name == "I") {
    memory_.build_text = std::string(value);
    return;
  }
  if (name == "N0" || name == "N1") {
    if (is_locked_) throw LineError(kNotIdle);
    if (!value.empty()) ObeyBlock(ReadBlock(value, modal_));  // Else it is not kept.
    memory_.startup_lines[name == "N0" ? 0 : 1] = std::string(value);
    return;
  }
  std::size_t at = 0;
  const auto number = ReadNumber(name, &at);
  if (!number || at != name.size()) throw LineError(kBadNumber);
  at = 0;
  const auto to = ReadNumber(value, &at);
  if (!to || at != value.size()) throw LineError(kBadNumber);
  constexpr double kMostSettings = 255;
  if (*number < 0 || *number > kMostSettings) throw LineError(kInvalidStatement);
  memory_.Set(static_cast<int>(*number), *to);
  TakeSettings();
}

void Controller::Restore(std::string_view what) {
  if (what != "$" && what != "#" && what != "*") throw LineError(kInvalidStatement);
  if (what != "#") memory_.RestoreSettings();
  if (what != "$") memory_.ForgetPlaces();
  if (what == "*") {
    memory_.startup_lines.fill("");
    memory_.build_text.clear();
  }
  TakeSettings();
  said_.emplace_back("[MSG:Restoring defaults]");
  begins_anew_ = true;
}

void Controller::Home() {
  if (!memory_.Is(kHomingCycle)) throw LineError(kHomingIsOff);
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    live_.is_homing = true;
  }
  const double pull_off_mm = memory_.Value(kHomingPullOff);
  const Motion::Homing homing{
      .fast_mm_s = FeedFromWord_mm_s(memory_.Value(kHomingSeek)),
      .slow_mm_s = FeedFromWord_mm_s(memory_.Value(kHomingFeed)),
      .back_off_mm = pull_off_mm,
      .pull_off_mm = pull_off_mm};
  const auto mask = static_cast<unsigned>(memory_.Value(kHomingMask));
  bool has_switches = true;
  for (const Axis axis : {Axis::kZ, Axis::kX, Axis::kY}) {
    const bool to_min = (mask & (1U << static_cast<unsigned>(Index(axis)))) != 0;
    const AxisDrawing& drawing = machine_.axis(axis);
    // Away from its switch there is nothing that it could meet.
    has_switches = has_switches && to_min == (drawing.home == HomeEnd::kMin) &&
                   motion_.Home(axis, homing);
    if (!has_switches) break;
    motion_.SetPosition(
        axis,
        to_min ? pull_off_mm - memory_.Value(kMaxTravel + Index(axis)) : -pull_off_mm);
  }
  if (pace_->is_stopped()) return;
  is_locked_ = !has_switches;
  motion_.Acknowledge();
  Publish();
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    live_.is_homing = false;
  }
  if (has_switches) return RunStartupLines();
  Lock(Alarm::kNoSwitch);
  begins_anew_ = true;
}

void Controller::Jog(std::string_view line) {
  const bool is_idle = !is_performing_ && !motion_.has_queued();
  if (is_locked_ || is_checking_ || (!is_idle && !is_jogging()))
    throw LineError(kNotIdle);
  Block block = ReadBlock(line, modal_);
  // Nothing but units, distances and G53 may stand beside its places and its feed.
  const bool is_jog =
      block.axis_command == Block::AxisCommand::kMotion && !block.has_more_than_jog;
  if (!is_jog) throw LineError(kInvalidJog);
  if (!block.has_axis_words()) throw LineError(kNoAxisWords);
  const auto feed_mm_min = TakeLength_mm(&block, 'F');
  if (!feed_mm_min || *feed_mm_min == 0) throw LineError(kUndefinedFeed);
  const Vec3<double> target_mm = TakeTarget_mm(&block);
  if (block.HasValues()) throw LineError(kUnusedWords);
  if (memory_.Is(kSoftLimits) && IsBeyondLimits(target_mm)) {
    throw LineError(kTravelExceeded);
  }
  MoveTo(target_mm, FeedFromWord_mm_s(*feed_mm_min));
  if (!pace_->is_timed()) return motion_.Finish();
  const std::lock_guard<std::mutex> lock(live_mutex_);
  live_.is_jogging = is_performing_ || motion_.has_queued();
}

}  // namespace caltwin::grbl
