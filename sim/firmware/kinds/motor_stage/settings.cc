#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <ctime>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/firmware/kinds/motor_stage/controller.h"

// What the controller keeps: the record of each axis, by M-code and in the flash.

namespace caltwin {
namespace {

char LetterOf(std::size_t axis) {
  return static_cast<char>(std::toupper(kMotorAxisLetters[axis]));
}

Reply Refusal(const std::string& why) {
  return {.lines = {"Error: " + why}, .error = true};
}

std::int32_t WholePulses(double pulses) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::llround(std::clamp(pulses, -kMost, kMost)));
}

/// One field of the record behind an M-code, in units of travel.
struct FieldCode {
  int code = 0;
  double (*get)(const AxisCalibration&) = nullptr;
  void (*set)(double, AxisCalibration*) = nullptr;
};

// New pulses per unit keep the pulses of every other field.
const std::array kFields = {
    FieldCode{92,
              [](const AxisCalibration& r) { return r.pulses_per_unit; },
              [](double v, AxisCalibration* r) {
                r->pulses_per_unit = v;
              }},
    FieldCode{201,
              [](const AxisCalibration& r) {
                return r.max_acceleration_pulses_s2 / r.pulses_per_unit;
              },
              [](double v, AxisCalibration* r) {
                r->max_acceleration_pulses_s2 = v * r->pulses_per_unit;
              }},
    FieldCode{203,
              [](const AxisCalibration& r) {
                return r.max_velocity_pulses_s / r.pulses_per_unit;
              },
              [](double v, AxisCalibration* r) {
                r->max_velocity_pulses_s = v * r->pulses_per_unit;
              }},
    FieldCode{206,
              [](const AxisCalibration& r) {
                return r.home_offset_pulses / r.pulses_per_unit;
              },
              [](double v, AxisCalibration* r) {
                r->home_offset_pulses = WholePulses(v * r->pulses_per_unit);
              }},
    FieldCode{
        425,
        [](const AxisCalibration& r) { return r.backlash_pulses / r.pulses_per_unit; },
        [](double v, AxisCalibration* r) {
          r->backlash_pulses = v * r->pulses_per_unit;
        }},
    FieldCode{
        812,
        [](const AxisCalibration& r) { return static_cast<double>(r.pulses_per_rev); },
        [](double v, AxisCalibration* r) {
          r->pulses_per_rev =
              static_cast<std::uint32_t>(std::clamp(std::round(v), 0.0, 4e9));
        }},
    FieldCode{813,
              [](const AxisCalibration& r) { return r.index_enabled ? 1.0 : 0.0; },
              [](double v, AxisCalibration* r) {
                r->index_enabled = v != 0;
              }}};

// Why a field cannot hold a number, which it would cut off or round; else "".
std::string CannotHold(int code, double value, const AxisCalibration& record) {
  constexpr double kMostPulses = std::numeric_limits<std::int32_t>::max();
  constexpr double kMostPerRev = std::numeric_limits<std::uint32_t>::max();
  if (code == 813 && value != 0 && value != 1) return "0 or 1 are allowed";
  if (code == 812 && (std::round(value) != value || value < 0 || value > kMostPerRev)) {
    return fmt::format("whole pulses from 0 to {:.0f} are allowed", kMostPerRev);
  }
  const bool is_place = code == 206 || code == 208;
  if (is_place && !(std::abs(value * record.pulses_per_unit) <= kMostPulses)) {
    return fmt::format(
        "up to {:.0f} pulses either way are allowed, {:g} times {:g} here",
        kMostPulses,
        value,
        record.pulses_per_unit);
  }
  return "";
}

std::string Date(std::int64_t unix_s) {
  const auto time = static_cast<std::time_t>(unix_s);
  std::tm utc{};
  gmtime_r(&time, &utc);
  return fmt::format("{:04d}-{:02d}-{:02d}T{:02d}:{:02d}:{:02d}Z",
                     utc.tm_year + 1900,
                     utc.tm_mon + 1,
                     utc.tm_mday,
                     utc.tm_hour,
                     utc.tm_min,
                     utc.tm_sec);
}

}  // namespace

Reply MotorStageFirmware::Settings(const GcodeCommand& command) {
  switch (command.code) {
    case 17:
      return Enable(command, true);
    case 18:
    case 84:
      return Enable(command, false);
    case 112:
      return Stop();
    case 999:
      return Clear();
    case 114:
      return Positions();
    case 119:
      return Switches();
    case 400:
      return WaitForAll();
    case 810:
      return ForgetHome(command);
    case 811:
      return SetZero(command);
    case 814:
    case 815:
      return Drives(command);
    case 816:
      return Delays(command);
    case 817: {
      const double after_s = command.Number('S').value_or(0);
      if (after_s < 0) return Refusal("M817 S: 0 s or more");
      motion_.ArmRelay(after_s);
      return {};
    }
    case 818:
      return StopReports();
    case 208:
      return Limits(command);
    case 500:
      return StoreRecords(command);
    case 501:
      return LoadRecords();
    case 502:
      return FactoryReset(command);
    case 504:
      return History();
    case 505:
      return Note(command);
    default:
      return Field(command);
  }
}

Reply MotorStageFirmware::Field(const GcodeCommand& command) {
  const auto* field = std::ranges::find(kFields, command.code, &FieldCode::code);
  if (field == kFields.end()) {
    return Refusal(fmt::format("{} is not known to this machine", command.Name()));
  }
  Reply reply;
  for (const std::size_t i : Named(command)) {
    Axis& axis = axes_[i];
    if (const auto value = command.Number(LetterOf(i))) {
      AxisCalibration changed = axis.record;
      if (const auto why = CannotHold(command.code, *value, changed); !why.empty()) {
        return Refusal(fmt::format("{} {}: {}", command.Name(), LetterOf(i), why));
      }
      field->set(*value, &changed);
      const auto faults = RangeFaults(changed);
      if (!faults.empty()) {
        return Refusal(fmt::format(
            "{} {}: {}", command.Name(), LetterOf(i), fmt::join(faults, "; ")));
      }
      axis.record = changed;
      continue;
    }
    reply.lines.push_back(
        fmt::format("{}:{:.8g}", LetterOf(i), field->get(axis.record)));
  }
  return reply;
}

// M816 X0.0005: not of the record; gone with the power.
Reply MotorStageFirmware::Delays(const GcodeCommand& command) {
  constexpr double kMost_s = 0.1;
  Reply reply;
  for (const std::size_t i : Named(command)) {
    double& delay_s = motion_.axis(i).delay_s;
    const auto value = command.Number(LetterOf(i));
    if (!value) {
      reply.lines.push_back(fmt::format("{}:{:.8g}", LetterOf(i), delay_s));
    } else if (*value >= 0 && *value <= kMost_s) {
      delay_s = *value;
    } else {
      return Refusal(
          fmt::format("M816 {}: 0 to {:g} s are allowed", LetterOf(i), kMost_s));
    }
  }
  return reply;
}

// M208 X0 S1: lower ends; M208 X200 S0: upper ends.
Reply MotorStageFirmware::Limits(const GcodeCommand& command) {
  const double which = command.Number('S').value_or(0);
  if (which != 0 && which != 1) {
    return Refusal("M208 S: 1 is the lower end, 0 the upper");
  }
  const bool is_min = which == 1;
  Reply reply;
  for (const std::size_t i : Named(command)) {
    Axis& axis = axes_[i];
    AxisCalibration changed = axis.record;
    std::int32_t& end =
        is_min ? changed.min_position_pulses : changed.max_position_pulses;
    if (const auto value = command.Number(LetterOf(i))) {
      if (const auto why = CannotHold(208, *value, changed); !why.empty()) {
        return Refusal(fmt::format("M208 {}: {}", LetterOf(i), why));
      }
      end = WholePulses(*value * changed.pulses_per_unit);
      const auto faults = RangeFaults(changed);
      if (!faults.empty()) {
        return Refusal(
            fmt::format("M208 {}: {}", LetterOf(i), fmt::join(faults, "; ")));
      }
      axis.record = changed;
      axis.has_limits = true;
      continue;
    }
    reply.lines.push_back(
        fmt::format("{}:{:.8g}", LetterOf(i), end / changed.pulses_per_unit));
  }
  return reply;
}

Reply MotorStageFirmware::StoreRecords(const GcodeCommand& command) {
  for (const std::size_t i : Named(command)) {
    const bool is_stored =
        store_.Store(static_cast<std::uint8_t>(i), axes_[i].record, Now_unix_s());
    if (!is_stored) return Refusal("the power went while storing");
  }
  return {};
}

// A record that was stored before its limits were measured holds the factory's.
void MotorStageFirmware::LoadRecord(std::size_t i) {
  const AxisCalibration& factory = options_.factory[i];
  const auto stored = store_.Record(static_cast<std::uint8_t>(i));
  const AxisCalibration& record = stored ? *stored : factory;
  axes_[i].has_limits = record.min_position_pulses != factory.min_position_pulses ||
                        record.max_position_pulses != factory.max_position_pulses;
  axes_[i].has_limits = axes_[i].has_limits;
  axes_[i].record = record;
}

Reply MotorStageFirmware::LoadRecords() {
  store_ = RecordStore(flash_);
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) LoadRecord(i);
  return {};
}

Reply MotorStageFirmware::FactoryReset(const GcodeCommand& command) {
  const Axes named = Named(command);
  const bool is_all = named.size() == kNumMotorAxes;
  for (const std::size_t i : named) {
    const auto axis = is_all ? kAllAxes : static_cast<std::uint8_t>(i);
    if (!store_.FactoryReset(axis, Now_unix_s())) {
      return Refusal("the power went while storing");
    }
    if (is_all) break;
  }
  for (const std::size_t i : named) LoadRecord(i);
  return {};
}

Reply MotorStageFirmware::History() const {
  Reply reply;
  for (const HistoryEntry& entry : store_.history()) {
    const std::string axis = entry.axis == kAllAxes ? "all" : MotorAxisName(entry.axis);
    const std::string what = entry.kind == HistoryEntry::Kind::kNote ? entry.note
                             : entry.kind == HistoryEntry::Kind::kFactoryReset
                                 ? "factory reset"
                                 : "calibrated";
    reply.lines.push_back(
        fmt::format("{} {} {}: {}", entry.sequence, Date(entry.unix_s), axis, what));
  }
  return reply;
}

// M505 X P"text": a line of the error log.
Reply MotorStageFirmware::Note(const GcodeCommand& command) {
  const GcodeWord* text = command.Find('P');
  if (text == nullptr || text->kind != GcodeWord::Kind::kQuoted) {
    return Refusal("M505 needs P\"text\"");
  }
  const Axes named = Named(command);
  const auto axis = named.size() == 1 ? static_cast<std::uint8_t>(named[0]) : kAllAxes;
  if (!store_.Note(axis, text->text, Now_unix_s())) {
    return Refusal("the power went while storing");
  }
  return {};
}

}  // namespace caltwin
