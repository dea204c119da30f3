#include "calibration/kinds/motor_stage/motor_axes.h"

#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/link/gcode.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kMotorAxesPatience{600'000};

char LetterOf(std::size_t axis) {
  return static_cast<char>(std::toupper(kMotorAxisLetters[axis]));
}

std::string Code(const std::string& code, std::size_t axis) {
  return fmt::format("{} {}", code, LetterOf(axis));
}

std::string Code(const std::string& code, std::size_t axis, double value) {
  return Code(code, axis) + GcodeNumber(value, 6);
}

MachineFault Unreadable(const std::string& command, const std::string& answer) {
  return {.reply = fmt::format("Could not read '{}' to {}: is this a motor stage's "
                               "controller?",
                               answer,
                               command)};
}

}  // namespace

std::optional<MotorCondition> ConditionOf(const MachineFault& fault,
                                          const MotorStageDrawing& drawing) {
  using Kind = MotorCondition::Kind;
  // "X is blocked at 121.700: ...", "G1: X MIN switch not found within 250".
  const auto named = [&](const std::string& words) -> std::optional<std::size_t> {
    const std::size_t at = fault.reply.find(words);
    if (at == std::string::npos || at == 0) return std::nullopt;
    const auto letter = static_cast<char>(std::tolower(fault.reply[at - 1]));
    return MotorAxisNamed(std::string(1, letter));
  };
  const auto within = [&](std::size_t axis) {
    return fmt::format("within {:g} {}",
                       NumberBehind(fault.reply, "within").value_or(0),
                       drawing.axes[axis].unit());
  };
  if (const auto axis = named(" is blocked at")) {
    return MotorCondition{
        .kind = Kind::kBlocked,
        .axis = *axis,
        .words = fmt::format("motion of {} is blocked at {:.1f} {}",
                             MotorAxisName(*axis),
                             NumberBehind(fault.reply, "at").value_or(0),
                             drawing.axes[*axis].unit()),
        .remedy = "is something in the way?"};
  }
  for (const std::string end : {"MIN", "MAX"}) {
    if (const auto axis = named(" " + end + " switch not found")) {
      return MotorCondition{.kind = Kind::kSwitchMissing,
                            .axis = *axis,
                            .words = fmt::format("end switch {} of {} not detected {}",
                                                 end,
                                                 MotorAxisName(*axis),
                                                 within(*axis)),
                            .remedy = drawing.axes[*axis].is_servo
                                          ? "is its wire on?"
                                          : "is its wire on, or is something in the "
                                            "way? A stepper does not tell",
                            .can_move = end == "MAX"};
    }
  }
  if (const auto axis = named(" index not found")) {
    return MotorCondition{
        .kind = Kind::kIndexMissing,
        .axis = *axis,
        .words =
            fmt::format("no index pulse of {} {}", MotorAxisName(*axis), within(*axis)),
        .remedy = "is its wire on, is it enabled (M813)?",
        .can_move = true};
  }
  return std::nullopt;
}

std::optional<double> NumberBehind(const std::string& line, const std::string& key) {
  const std::size_t at = line.find(" " + key + " ");
  if (at == std::string::npos) return std::nullopt;
  const char* from = line.data() + at + key.size() + 2;
  double value = 0;
  const auto read = std::from_chars(from, line.data() + line.size(), value);
  if (read.ec != std::errc()) return std::nullopt;
  return value;
}

Expected<std::vector<std::string>> MotorAxes::Say(const std::string& line) {
  auto answer = bench_.link->Send(line, kMotorAxesPatience);
  if (answer) return answer;
  MachineFault fault = answer.error();
  if (const auto condition = ConditionOf(fault, bench_.drawing)) {
    fault.kind = condition->kind == MotorCondition::Kind::kBlocked
                     ? MachineFault::Kind::kAlarm
                     : MachineFault::Kind::kNoTrigger;
  }
  return tl::unexpected(fault);
}

Expected<void> MotorAxes::Do(const std::string& line) {
  const auto answer = Say(line);
  if (!answer) return tl::unexpected(answer.error());
  return {};
}

// The line of the answer that begins with the axis' letter.
Expected<std::string> MotorAxes::LineOf(const std::string& command, std::size_t axis) {
  const auto answer = Say(command);
  if (!answer) return tl::unexpected(answer.error());
  for (const std::string& line : *answer) {
    if (!line.empty() && std::toupper(line[0]) == LetterOf(axis)) return line;
  }
  return tl::unexpected(Unreadable(command, answer->empty() ? "" : answer->back()));
}

Expected<void> MotorAxes::MoveBy(std::size_t axis,
                                 double by_unit,
                                 double speed_unit_s) {
  if (const auto done = Do("G91"); !done) return done;
  const std::pair<char, double> word{LetterOf(axis), by_unit};
  if (const auto done = Do(GcodeMove("G1", {word}, speed_unit_s)); !done) return done;
  return WaitComplete();
}

Expected<void> MotorAxes::MoveTo(std::size_t axis,
                                 double to_unit,
                                 double speed_unit_s) {
  if (const auto done = Do("G90"); !done) return done;
  const std::pair<char, double> word{LetterOf(axis), to_unit};
  if (const auto done = Do(GcodeMove("G1", {word}, speed_unit_s)); !done) return done;
  return WaitComplete();
}

Expected<void> MotorAxes::MoveTogether(const std::vector<std::size_t>& axes,
                                       double by_unit,
                                       double speed_unit_s) {
  if (const auto done = Do("G91"); !done) return done;
  std::vector<std::pair<char, double>> words;
  words.reserve(axes.size());
  for (const std::size_t axis : axes) words.emplace_back(LetterOf(axis), by_unit);
  return Do(GcodeMove("G1", words, speed_unit_s));
}

Expected<void> MotorAxes::SeekSwitch(std::size_t axis,
                                     double by_unit,
                                     double speed_unit_s) {
  if (const auto done = Do("G91"); !done) return done;
  return Do(GcodeMove("G1 H4", {{LetterOf(axis), by_unit}}, speed_unit_s));
}

Expected<void> MotorAxes::SeekIndex(std::size_t axis,
                                    double by_unit,
                                    double speed_unit_s) {
  if (const auto done = Do("G91"); !done) return done;
  return Do(GcodeMove("G1 H5", {{LetterOf(axis), by_unit}}, speed_unit_s));
}

Expected<void> MotorAxes::Enable(std::size_t axis, bool on) {
  return Do(Code(on ? "M17" : "M18", axis));
}

Expected<bool> MotorAxes::IsPressed(std::size_t axis, bool is_min) {
  const double known_s = 2 * (bench_.drawing.poll_s + bench_.drawing.transfer_s);
  if (const auto waited = Do("G4 S" + GcodeNumber(known_s, 6)); !waited) {
    return tl::unexpected(waited.error());
  }
  const auto line = LineOf("M119", axis);
  if (!line) return tl::unexpected(line.error());
  const std::string pin =
      fmt::format("{}_{}: TRIGGERED", kMotorAxisLetters[axis], is_min ? "min" : "max");
  return line->find(pin) != std::string::npos;
}

Expected<std::int64_t> MotorAxes::Count(std::size_t axis) {
  const auto line = LineOf("M114", axis);
  if (!line) return tl::unexpected(line.error());
  const auto count = NumberBehind(*line, "Count");
  if (!count) return tl::unexpected(Unreadable("M114", *line));
  return std::llround(*count);
}

Expected<DriveSays> MotorAxes::Drive(std::size_t axis) {
  const auto line = LineOf(Code("M814", axis), axis);
  if (!line) return tl::unexpected(line.error());
  DriveSays says{
      .index_edges = static_cast<int>(NumberBehind(*line, "edges").value_or(0)),
      .peak_a = NumberBehind(*line, "peak_a").value_or(0),
      .half_way_s = NumberBehind(*line, "half_way_s"),
      .is_homed = NumberBehind(*line, "homed").value_or(0) == 1,
      .was_homed = NumberBehind(*line, "was_homed").value_or(0) == 1};
  if (const auto index = NumberBehind(*line, "index")) {
    says.index = std::llround(*index);
  }
  return says;
}

Expected<void> MotorAxes::ClearDrive(std::size_t axis) {
  return Do(Code("M815", axis));
}

Expected<StopSays> MotorAxes::LastStop(std::size_t axis) {
  const auto line = LineOf("M818", axis);
  if (!line) return tl::unexpected(line.error());
  const auto standstill_s = NumberBehind(*line, "standstill_s");
  if (!standstill_s) return tl::unexpected(Unreadable("M818", *line));
  return StopSays{
      .standstill_s = *standstill_s,
      .sd_s = NumberBehind(*line, "sd_s").value_or(0),
      .rests_s = NumberBehind(*line, "rests_s").value_or(0),
      .brakes_s = NumberBehind(*line, "brakes_s").value_or(bench_.BrakesAfter_s()),
      .told_unit_s = NumberBehind(*line, "told").value_or(0),
      .path_unit = NumberBehind(*line, "path").value_or(0),
      .peak_a = NumberBehind(*line, "peak_a").value_or(0),
      .stood = NumberBehind(*line, "stood").value_or(0) == 1,
      .is_knocked = NumberBehind(*line, "knocked").value_or(0) == 1,
      .is_disabled = NumberBehind(*line, "enabled").value_or(1) == 0};
}

Expected<void> MotorAxes::ArmRelay(double after_s) {
  return Do("M817 S" + GcodeNumber(after_s, 6));
}

Expected<void> MotorAxes::Resume() {
  if (const auto done = Do("M999"); !done) return done;
  return Do("M17");
}

Expected<void> MotorAxes::ForgetHome(std::size_t axis) {
  return Do(Code("M810", axis));
}

Expected<void> MotorAxes::SetZero(std::size_t axis, std::int64_t count) {
  return Do(Code("M811", axis, static_cast<double>(count)));
}

Expected<double> MotorAxes::NumberOf(const std::string& command, std::size_t axis) {
  const auto line = LineOf(command, axis);
  if (!line) return tl::unexpected(line.error());
  double value = 0;
  const auto read =
      std::from_chars(line->data() + 2, line->data() + line->size(), value);
  if (line->size() < 3 || read.ec != std::errc()) {
    return tl::unexpected(Unreadable(command, *line));
  }
  return value;
}

Expected<double> MotorAxes::Field(int code, std::size_t axis) {
  return NumberOf(Code(fmt::format("M{}", code), axis), axis);
}

Expected<double> MotorAxes::LowerLimit(std::size_t axis) {
  return NumberOf(Code("M208 S1", axis), axis);
}

Expected<void> MotorAxes::SetField(int code, std::size_t axis, double value) {
  return Do(Code(fmt::format("M{}", code), axis, value));
}

// Whichever way the new range lies, the ends never cross: the upper one far off first.
Expected<void> MotorAxes::SetLimits(std::size_t axis,
                                    double min_unit,
                                    double max_unit) {
  if (const auto wide = Do(Code("M208 S0", axis, 1e5)); !wide) return wide;
  if (const auto low = Do(Code("M208 S1", axis, min_unit)); !low) return low;
  return Do(Code("M208 S0", axis, max_unit));
}

Expected<double> MotorAxes::Delay_s(std::size_t axis) {
  return Field(816, axis);
}

Expected<void> MotorAxes::SetDelay_s(std::size_t axis, double delay_s) {
  return Do(Code("M816", axis, delay_s));
}

Expected<void> MotorAxes::Store(std::size_t axis) {
  return Do(Code("M500", axis));
}

Expected<void> MotorAxes::Log(std::size_t axis, const std::string& text) {
  std::string quoted;
  for (const char c : text) quoted += c == '"' ? '\'' : c;
  return Do(Code("M505", axis) + fmt::format(" P\"{}\"", quoted));
}

}  // namespace caltwin
