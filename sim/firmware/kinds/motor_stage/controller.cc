#include "sim/firmware/kinds/motor_stage/controller.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/firmware/kinds/motor_stage/code_words.h"

namespace caltwin {
namespace {

constexpr double kComplete_s = 0.5;  // Patience of M400.

char LetterOf(std::size_t axis) {
  return static_cast<char>(std::toupper(kMotorAxisLetters[axis]));
}

Reply Refusal(const std::string& why) {
  return {.lines = {"Error: " + why}, .error = true};
}

}  // namespace

MotorStageFirmware::MotorStageFirmware(const MotorStageOptions& options,
                                       MotorRig* rig,
                                       Flash* flash)
    : options_(options), motion_(options.motion, rig), flash_(flash), store_(flash) {
  LoadRecords();
}

MotorStageFirmware::Axes MotorStageFirmware::Named(const GcodeCommand& command) {
  Axes named, all;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    all.push_back(i);
    if (command.Find(LetterOf(i)) != nullptr) named.push_back(i);
  }
  return named.empty() ? all : named;
}

Reply MotorStageFirmware::Execute(std::string_view line) {
  GcodeLine parsed;
  try {
    parsed = ParseGcode(line);
  } catch (const InputError& error) {
    return Refusal(error.what());
  }
  if (parsed.is_meta) return Refusal("meta commands are not known here");
  Reply reply;
  for (const GcodeCommand& command : parsed.commands) {
    const Reply part = Obey(command);
    DistrustSteppersWithoutPower();
    reply.lines.insert(reply.lines.end(), part.lines.begin(), part.lines.end());
    reply.error = reply.error || part.error;
  }
  return reply;
}

// A rotor without its field is anywhere, and nothing counts it.
void MotorStageFirmware::DistrustSteppersWithoutPower() {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const bool is_lost = !options_.motion.is_servo[i] && !motion_.axis(i).is_enabled;
    if (is_lost) axes_[i].is_homed = false;
  }
}

Reply MotorStageFirmware::Obey(const GcodeCommand& command) {
  if (const auto fault = MotorWordFault(command); !fault.empty()) {
    return Refusal(fmt::format("{}: {}", command.Name(), fault));
  }
  if (command.Is('G', 90) || command.Is('G', 91)) {
    is_relative_ = command.code == 91;
    return {};
  }
  if (command.Is('G', 0) || command.Is('G', 1)) {
    Reply reply = Move(command);
    motion_.DisarmRelay();  // It was for this move, also if that was refused.
    return reply;
  }
  if (command.Is('G', 4)) {
    constexpr double kLongest_s = 3600;
    const double wait_s = command.Number('S').value_or(0);
    if (wait_s < 0 || wait_s > kLongest_s) {
      return Refusal(fmt::format("G4 S: 0 to {:g} s", kLongest_s));
    }
    motion_.Wait(wait_s);
    return {};
  }
  if (command.letter == 'M') return Settings(command);
  return Refusal(fmt::format("{} is not known to this machine", command.Name()));
}

double MotorStageFirmware::CommandedAt(std::size_t i) const {
  const Axis& axis = axes_[i];
  const double pulses = motion_.axis(i).target_pulses - static_cast<double>(axis.zero) -
                        axis.compensation_pulses;
  return pulses / axis.record.pulses_per_unit;
}

// Zero is reached in +: moving in - the motor goes further by the backlash.
double MotorStageFirmware::TargetFor(std::size_t i, double to_unit) {
  Axis& axis = axes_[i];
  const double way_unit = to_unit - CommandedAt(i);
  if (way_unit > 0) axis.compensation_pulses = 0;
  if (way_unit < 0) axis.compensation_pulses = -axis.record.backlash_pulses;
  return to_unit * axis.record.pulses_per_unit + static_cast<double>(axis.zero) +
         axis.compensation_pulses;
}

std::string MotorStageFirmware::LimitFault(std::size_t i, double to_unit) const {
  const Axis& axis = axes_[i];
  if (!axis.is_homed || !axis.has_limits) return "";
  const double low_unit = axis.record.min_position_pulses / axis.record.pulses_per_unit;
  const double high_unit =
      axis.record.max_position_pulses / axis.record.pulses_per_unit;
  constexpr double kRounding_unit = 1e-9;
  const auto beyond = [&](double at_unit) {
    return std::max({low_unit - at_unit, at_unit - high_unit, 0.0});
  };
  // What stands outside (at a switch) may come back.
  const bool is_allowed =
      beyond(to_unit) <= kRounding_unit || (beyond(to_unit) < beyond(CommandedAt(i)));
  if (is_allowed) return "";
  return fmt::format("{}{:g} is outside its limits {:g} .. {:g}; nothing moved",
                     LetterOf(i),
                     to_unit,
                     low_unit,
                     high_unit);
}

Reply MotorStageFirmware::Move(const GcodeCommand& command) {
  if (motion_.is_stopped()) return Refusal("emergency stop: M999 clears it");
  if (const auto feed = command.Number('F')) feed_unit_s_ = FeedFromWord_mm_s(*feed);
  if (feed_unit_s_ <= 0) return Refusal("F must be above 0");
  const auto hunt = static_cast<int>(command.Number('H').value_or(0));
  if (hunt != 0 && hunt != 4 && hunt != 5) return Refusal("H is 0, 4 or 5");
  MotorMove move;
  std::array<double, kNumMotorAxes> way_unit{}, far_unit{};
  double speed_part = 1e9, slow_part = 1e9;
  std::size_t moving = 0;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const auto word = command.Number(LetterOf(i));
    if (!word) continue;
    const double to_unit = is_relative_ ? CommandedAt(i) + *word : *word;
    if (hunt == 0) {
      if (const std::string fault = LimitFault(i, to_unit); !fault.empty()) {
        return Refusal(fault);
      }
    }
    if (!motion_.axis(i).is_enabled) {
      return Refusal(fmt::format("{} is disabled: M17 enables it", LetterOf(i)));
    }
    way_unit[i] = to_unit - CommandedAt(i);
    move.moves[i] = true;
    move.to_pulses[i] = TargetFor(i, to_unit);
    move.watched = i;
    ++moving;
    // Its motor also goes what it takes up of the gap, and no faster for that.
    far_unit[i] = std::abs(move.to_pulses[i] - motion_.axis(i).target_pulses) /
                  axes_[i].record.pulses_per_unit;
    move.length_unit = std::max(move.length_unit, far_unit[i]);
  }
  if (moving == 0) return {};
  if (hunt != 0 && moving != 1) return Refusal("H4 and H5 move one axis");
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const double share = far_unit[i] / std::max(move.length_unit, 1e-12);
    if (!move.moves[i] || share == 0) continue;
    const AxisCalibration& record = axes_[i].record;
    speed_part = std::min(
        speed_part, record.max_velocity_pulses_s / record.pulses_per_unit / share);
    slow_part = std::min(
        slow_part, record.max_acceleration_pulses_s2 / record.pulses_per_unit / share);
  }
  move.speed_unit_s = std::min(feed_unit_s_, speed_part);
  move.acceleration_unit_s2 = slow_part;
  if (hunt == 4) move.until = MotorMove::Until::kSwitch;
  if (hunt == 5) move.until = MotorMove::Until::kIndex;
  move.end = way_unit[move.watched] > 0 ? SwitchEnd::kMax : SwitchEnd::kMin;
  return Arrived(command, move);
}

Reply MotorStageFirmware::Arrived(const GcodeCommand& command, const MotorMove& move) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    motion_.axis(i).index_enabled = axes_[i].record.index_enabled;
  }
  if (move.until == MotorMove::Until::kIndex &&
      !motion_.axis(move.watched).index_enabled) {
    return Refusal(fmt::format("{0}: the index of {1} is off (M813 {1}1 has it on)",
                               command.Name(),
                               LetterOf(move.watched)));
  }
  const MotorArrival arrival = motion_.Perform(move);
  if (arrival.stopped) return Refusal("emergency stop during the move");
  if (arrival.blocked) {
    const std::size_t i = *arrival.blocked;
    const double at_unit = static_cast<double>(motion_.Count(i) - axes_[i].zero) /
                           axes_[i].record.pulses_per_unit;
    return Refusal(
        fmt::format("{} is blocked at {:.3f}: at its current limit for "
                    "30 ms, stopped there",
                    LetterOf(i),
                    at_unit));
  }
  if (move.until == MotorMove::Until::kArrived || arrival.found) return {};
  const bool is_switch = move.until == MotorMove::Until::kSwitch;
  return Refusal(fmt::format("{}: {} {} not found within {:g}",
                             command.Name(),
                             LetterOf(move.watched),
                             !is_switch                    ? "index"
                             : move.end == SwitchEnd::kMin ? "MIN switch"
                                                           : "MAX switch",
                             move.length_unit));
}

Reply MotorStageFirmware::WaitForAll() {
  const auto late = motion_.WaitInPosition(kComplete_s);
  if (!late) return {};
  const double off =
      static_cast<double>(motion_.Count(*late)) - motion_.axis(*late).target_pulses;
  return Refusal(fmt::format(
      "{} is not in position after 500 ms: {:.1f} pulses off", LetterOf(*late), off));
}

// M810 X: homing begins. Nobody knows where zero is, so no limit holds until M811.
Reply MotorStageFirmware::ForgetHome(const GcodeCommand& command) {
  for (const std::size_t i : Named(command)) {
    axes_[i].is_homed = false;
  }
  return {};
}

// M811 X123: that count is zero from now on, and the axis homed.
Reply MotorStageFirmware::SetZero(const GcodeCommand& command) {
  for (const std::size_t i : Named(command)) {
    const auto at = command.Number(LetterOf(i));
    if (!at) continue;
    axes_[i].zero += std::llround(*at);
    axes_[i].is_homed = true;
    axes_[i].was_homed = true;
  }
  return {};
}

Reply MotorStageFirmware::Positions() const {
  Reply reply;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    reply.lines.push_back(fmt::format("{}:{:.5f} Count {}",
                                      LetterOf(i),
                                      CommandedAt(i),
                                      motion_.Count(i) - axes_[i].zero));
  }
  return reply;
}

Reply MotorStageFirmware::Switches() const {
  Reply reply;
  const auto word = [&](std::size_t i, SwitchEnd end) {
    return motion_.KnownPressed(i, end) ? "TRIGGERED" : "open";
  };
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    reply.lines.push_back(fmt::format("{}_min: {} {}_max: {}",
                                      kMotorAxisLetters[i],
                                      word(i, SwitchEnd::kMin),
                                      kMotorAxisLetters[i],
                                      word(i, SwitchEnd::kMax)));
  }
  return reply;
}

// M814 reports; M815 forgets the index pulses and peaks counted so far.
Reply MotorStageFirmware::Drives(const GcodeCommand& command) {
  Reply reply;
  for (const std::size_t i : Named(command)) {
    MotorMotion::AxisState& axis = motion_.axis(i);
    if (command.Is('M', 815)) {
      axis.index_edges = 0;
      axis.last_index.reset();
      axis.peak_a = 0;
      continue;
    }
    std::string line = fmt::format(
        "{} homed {:d} was_homed {:d} enabled {:d} "
        "edges {} peak_a {:.3f}",
        LetterOf(i),
        axes_[i].is_homed,
        axes_[i].was_homed,
        axis.is_enabled,
        axis.index_edges,
        axis.peak_a);
    if (axis.last_index) {
      line += fmt::format(" index {}", *axis.last_index - axes_[i].zero);
    }
    if (axis.half_way_s) line += fmt::format(" half_way_s {:.6f}", *axis.half_way_s);
    if (axis.in_position_at_s) {
      line += fmt::format(" complete_s {:.5f}", *axis.in_position_at_s);
    }
    reply.lines.push_back(line);
  }
  return reply;
}

Reply MotorStageFirmware::StopReports() const {
  Reply reply;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const MotorMotion::AxisState& axis = motion_.axis(i);
    reply.lines.push_back(fmt::format(
        "{} standstill_s {:.7f} sd_s {:.7f} rests_s {:.5f} brakes_s {:.7f} told {:.5f} "
        "path {:.5f} peak_a {:.3f} "
        "stood {:d} enabled {:d} knocked {:d}",
        LetterOf(i),
        axis.stop.standstill_s,
        axis.stop.sd_s,
        axis.stop.rests_s,
        axis.stop.brakes_at_s,
        axis.stop.told_pulses_s / axes_[i].record.pulses_per_unit,
        axis.stop.path_pulses / axes_[i].record.pulses_per_unit,
        axis.stop.peak_a,
        axis.stop.is_done,
        axis.is_enabled,
        axis.stop.is_knocked));
  }
  return reply;
}

Reply MotorStageFirmware::Stop() {
  motion_.EmergencyStop();
  return {.lines = {"emergency stop: M999 clears it"}, .error = true};
}

Reply MotorStageFirmware::Clear() {
  motion_.ClearStop();
  return {};
}

Reply MotorStageFirmware::Enable(const GcodeCommand& command, bool on) {
  if (on && motion_.is_stopped()) return Refusal("emergency stop: M999 clears it");
  for (const std::size_t i : Named(command)) motion_.Enable(i, on);
  motion_.Wait(0.01);
  return {};
}

std::int64_t MotorStageFirmware::Now_unix_s() const {
  return options_.clock_unix_s + static_cast<std::int64_t>(motion_.time_s());
}

}  // namespace caltwin
