#include "calibration/loop/controller.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "sim/link/gcode.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kControllerPatience{600'000};
constexpr double kTravelFeedShare = 0.8;  // Of the axis's largest.
constexpr double kNoMove_mm = 1e-9;
constexpr int kStepsDecimals = 4;
constexpr int kGapDecimals = 4;

std::optional<double> LeadingNumber(std::string_view text) {
  const std::size_t start = text.find_first_not_of(" :=");
  if (start == std::string_view::npos) return std::nullopt;
  text.remove_prefix(start);
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  return value;
}

bool Contains(std::string_view text, std::string_view words) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), words.begin(), words.end(), same) !=
         text.end();
}

std::string Joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

// The first number in `text`, which is cut off behind it.
std::optional<double> NextNumber(std::string_view* text) {
  const auto begins = [](char c) {
    return (c >= '0' && c <= '9') || c == '-' || c == '.';
  };
  while (!text->empty()) {
    const auto at = std::ranges::find_if(*text, begins);
    text->remove_prefix(static_cast<std::size_t>(at - text->begin()));
    double value = 0;
    const auto [end, error] =
        std::from_chars(text->data(), text->data() + text->size(), value);
    if (error == std::errc()) {
      text->remove_prefix(static_cast<std::size_t>(end - text->data()));
      return value;
    }
    text->remove_prefix(text->empty() ? 0 : 1);
  }
  return std::nullopt;
}

// The numbers of "{0.02, 0.019, 0}", "[0.02,0.019,0]" or "0.02".
std::vector<double> NumbersIn(std::string_view text) {
  std::vector<double> numbers;
  while (const auto number = NextNumber(&text)) numbers.push_back(*number);
  return numbers;
}

}  // namespace

std::optional<double> NumberAfter(std::string_view reply, char letter) {
  for (std::size_t i = 0; i < reply.size(); ++i) {
    if (reply[i] != letter) continue;
    const bool inside_word =
        i > 0 && std::isalpha(static_cast<unsigned char>(reply[i - 1]));
    if (inside_word) continue;
    if (const auto number = LeadingNumber(reply.substr(i + 1))) return number;
  }
  return std::nullopt;
}

std::optional<Vec3<double>> CountOf(std::string_view reply) {
  const std::size_t at = reply.find("Count");
  if (at == std::string_view::npos) return std::nullopt;
  const std::size_t end = reply.find("Machine", at);
  std::string_view text = reply.substr(at + 5, end - at - 5);
  Vec3<double> counts;
  for (int i = 0; i < 3; ++i) {
    const auto count = NextNumber(&text);
    if (!count) return std::nullopt;
    counts[i] = *count;
  }
  return counts;
}

MachineFault Classified(MachineFault fault) {
  const bool no_contact = Contains(fault.reply, "was not triggered") ||
                          Contains(fault.reply, "during probing move") ||
                          Contains(fault.reply, "No trigger on");
  if (IsCollision(fault)) {
    fault.kind = MachineFault::Kind::kAlarm;
  } else if (fault.kind == MachineFault::Kind::kRefused && no_contact) {
    fault.kind = MachineFault::Kind::kNoTrigger;
  }
  return fault;
}

bool IsCollision(const MachineFault& fault) {
  return Contains(fault.reply, "stylus") || Contains(fault.reply, "overtravel") ||
         Contains(fault.reply, "collision");
}

Controller::Controller(Link* link, const Machine& drawing)
    : link_(link),
      drawing_(drawing),
      settings_(drawing.settings),
      position_mm_(Vec3<double>::Constant(kUnknown)),
      direction_(Vec3<double>::Constant(kUnknown)),
      drive_direction_(Vec3<double>::Constant(kUnknown)) {}

Expected<std::vector<std::string>> Controller::Send(const std::string& line) {
  auto reply = link_->Send(line, kControllerPatience);
  if (!reply) return tl::unexpected(Classified(reply.error()));
  for (const std::string& text : *reply) {
    if (text.starts_with("Error:")) {
      return tl::unexpected(
          Classified({.kind = MachineFault::Kind::kRefused, .reply = text}));
    }
  }
  return reply;
}

Expected<void> Controller::ReadSettings() {
  // Whoever was here before may have left the machine counting from where it stands.
  if (const auto absolute = Send("G90"); !absolute) {
    return tl::unexpected(absolute.error());
  }
  const auto steps = Send("M92");
  if (!steps) return tl::unexpected(steps.error());
  const auto gaps = Send("M425");
  if (!gaps) return tl::unexpected(gaps.error());
  for (const Axis axis : kAxes) {
    const char letter = CapitalLetter(axis);
    const auto i = static_cast<std::size_t>(Index(axis));
    if (const auto value = NumberAfter(Joined(*steps), letter)) {
      settings_.steps_per_mm[i] = *value;
    }
    if (const auto value = NumberAfter(Joined(*gaps), letter)) {
      settings_.backlash_mm[i] = *value;
    }
  }
  const auto deflection = ReadGlobal("nxtProbeDeflection");
  if (!deflection) return tl::unexpected(deflection.error());
  if (deflection->size() == 1) settings_.probe_deflection_mm.fill(deflection->front());
  if (deflection->size() == 3) {
    std::ranges::copy(*deflection, settings_.probe_deflection_mm.begin());
  }
  const auto radius = ReadGlobal("nxtProbeTipRadius");
  if (!radius) return tl::unexpected(radius.error());
  if (radius->size() == 1) settings_.tip_radius_mm = radius->front();
  return {};
}

// A controller that has no such global refuses to print it: then it is as it was.
Expected<std::vector<double>> Controller::ReadGlobal(const std::string& name) {
  const auto reply = Send("echo global." + name);
  if (reply) return NumbersIn(Joined(*reply));
  if (reply.error().kind == MachineFault::Kind::kRefused) return std::vector<double>{};
  return tl::unexpected(reply.error());
}

void Controller::Remember(const Settings& exact) {
  const auto near = [](const std::array<double, 3>& a, std::array<double, 3>* b) {
    constexpr double kPrinted = 0.00051;  // Controllers print three decimals.
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs(a[i] - (*b)[i]) < kPrinted) (*b)[i] = a[i];
    }
  };
  near(exact.steps_per_mm, &settings_.steps_per_mm);
  near(exact.backlash_mm, &settings_.backlash_mm);
  near(exact.probe_deflection_mm, &settings_.probe_deflection_mm);
}

Expected<void> Controller::WriteStepsPerMm(Axis axis, double steps_per_mm) {
  const std::string number = GcodeNumber(steps_per_mm, kStepsDecimals);
  const auto sent = Send(fmt::format("M92 {}{}", CapitalLetter(axis), number));
  if (!sent) return tl::unexpected(sent.error());
  settings_.steps_per_mm[static_cast<std::size_t>(Index(axis))] =
      NumbersIn(number).front();
  return {};
}

Expected<void> Controller::WriteBacklash(Axis axis, double gap_mm) {
  const std::string number = GcodeNumber(gap_mm, kGapDecimals);
  const auto sent = Send(fmt::format("M425 {}{}", CapitalLetter(axis), number));
  if (!sent) return tl::unexpected(sent.error());
  settings_.backlash_mm[static_cast<std::size_t>(Index(axis))] =
      NumbersIn(number).front();
  return {};
}

Expected<void> Controller::WriteDeflection(Axis axis, double deflection_mm) {
  std::array<double, 3> all_mm = settings_.probe_deflection_mm;
  const std::size_t i = static_cast<std::size_t>(Index(axis));
  all_mm[i] = deflection_mm;
  const std::string value = fmt::format("{{{}, {}, {}}}",
                                        GcodeNumber(all_mm[0], kGapDecimals),
                                        GcodeNumber(all_mm[1], kGapDecimals),
                                        GcodeNumber(all_mm[2], kGapDecimals));
  auto sent = Send("set global.nxtProbeDeflection = " + value);
  if (!sent && sent.error().kind == MachineFault::Kind::kRefused) {
    sent = Send("global nxtProbeDeflection = " + value);
  }
  if (!sent) return tl::unexpected(sent.error());
  const std::vector<double> written_mm = NumbersIn(value);
  settings_.probe_deflection_mm = {written_mm[0], written_mm[1], written_mm[2]};
  return {};
}

Expected<void> Controller::WriteSingleDeflection(double deflection_mm) {
  const std::string value = GcodeNumber(deflection_mm, kGapDecimals);
  auto sent = Send("set global.nxtProbeDeflection = " + value);
  if (!sent && sent.error().kind == MachineFault::Kind::kRefused) {
    sent = Send("global nxtProbeDeflection = " + value);
  }
  if (!sent) return tl::unexpected(sent.error());
  settings_.probe_deflection_mm.fill(NumbersIn(value).front());
  return {};
}

Expected<bool> Controller::IsHomed() {
  const auto reply = Send(R"(M409 K"move.axes[].homed")");
  if (!reply) {
    // Controllers without M409 do not tell, so they are homed once more.
    if (reply.error().kind == MachineFault::Kind::kRefused) return false;
    return tl::unexpected(reply.error());
  }
  const std::string text = Joined(*reply);
  return Contains(text, "true") && !Contains(text, "false");
}

Expected<void> Controller::Home() {
  if (const auto sent = Send("G28"); !sent) return tl::unexpected(sent.error());
  for (const Axis axis : kAxes) {
    const bool to_min = drawing_.axis(axis).home == HomeEnd::kMin;
    direction_[Index(axis)] = to_min ? -1 : 1;
  }
  const auto motors = drawing_.kind->AtHome(drawing_).motor_sense;
  drive_direction_ = motors.value_or(direction_);
  const auto position_mm = ReadPosition_mm();
  if (!position_mm) return tl::unexpected(position_mm.error());
  return {};
}

void Controller::NoteMotors(Row* row) const {
  const DriveMap* drives = drawing_.kind->drive_map();
  if (drives == nullptr) return;
  const Vec3<double> told_mm =
      DrivesOf(drives, {row->cmd_mm[0], row->cmd_mm[1], row->cmd_mm[2]});
  for (int i = 0; i < static_cast<int>(drawing_.kind->motors().size()); ++i) {
    row->motor_mm[static_cast<std::size_t>(i)] = told_mm[i];
    row->motor_dir[static_cast<std::size_t>(i)] = drive_direction_[i];
  }
}

Expected<void> Controller::Restart() {
  if (const auto sent = Send("M999"); !sent) return tl::unexpected(sent.error());
  direction_.setConstant(kUnknown);
  drive_direction_.setConstant(kUnknown);
  return ReadSettings();
}

Expected<void> Controller::MoveTo(const Vec3<double>& target_mm, double feed_mm_s) {
  double largest_mm_s = feed_mm_s > 0 ? feed_mm_s : 1e9;
  bool moves = false;
  for (const Axis axis : kAxes) {
    const double by_mm = target_mm[Index(axis)] - position_mm_[Index(axis)];
    if (std::abs(by_mm) <= kNoMove_mm) continue;
    moves = true;
    largest_mm_s =
        std::min(largest_mm_s, kTravelFeedShare * drawing_.axis(axis).max_feed_mm_s);
  }
  if (!moves) return {};
  return Move("G1", target_mm, largest_mm_s);
}

Expected<void> Controller::Move(const char* command,
                                const Vec3<double>& target_mm,
                                double feed_mm_s) {
  std::vector<std::pair<char, double>> words;
  for (const Axis axis : kAxes) {
    const double by_mm = target_mm[Index(axis)] - position_mm_[Index(axis)];
    if (std::abs(by_mm) <= kNoMove_mm) continue;
    words.emplace_back(CapitalLetter(axis), target_mm[Index(axis)]);
  }
  // G53: machine coordinates, whatever work offset is in force.
  const auto sent = Send("G53 " + GcodeMove(command, words, feed_mm_s));
  if (!sent) return tl::unexpected(sent.error());
  NoteMove(target_mm);
  return {};
}

void Controller::NoteMove(const Vec3<double>& target_mm) {
  for (int i = 0; i < 3; ++i) {
    const double by_mm = target_mm[i] - position_mm_[i];
    if (std::abs(by_mm) <= kNoMove_mm) continue;
    const double sense = by_mm > 0 ? 1 : -1;
    direction_[i] = sense;
  }
  const Vec3<double> by_drive =
      DrivesOf(drawing_.kind->drive_map(), target_mm - position_mm_);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(by_drive[i]) > kNoMove_mm) {
      drive_direction_[i] = std::copysign(1, by_drive[i]);
    }
  }
  position_mm_ = target_mm;
}

Expected<void> Controller::ProbeTowards(const Vec3<double>& target_mm,
                                        double feed_mm_s) {
  probe_move_ = {
      .from_mm = position_mm_, .target_mm = target_mm, .feed_mm_s = feed_mm_s};
  if (const auto moved = Move("G38.2", target_mm, feed_mm_s); !moved) return moved;
  probe_move_.reset();
  const auto position_mm = ReadPosition_mm();
  if (!position_mm) return tl::unexpected(position_mm.error());
  return {};
}

ProbeReading Controller::ReadProbe() {
  const auto answer = Send(kAskProbe);
  return answer ? ProbeReadingOf(*answer) : ProbeReading::kUnknown;
}

Expected<void> Controller::ProbeAway(const Vec3<double>& target_mm, double feed_mm_s) {
  if (const auto moved = Move("G38.4", target_mm, feed_mm_s); !moved) return moved;
  const auto position_mm = ReadPosition_mm();
  if (!position_mm) return tl::unexpected(position_mm.error());
  return {};
}

Expected<Vec3<double>> Controller::ReadPosition_mm() {
  const auto reply = Send("M114");
  if (!reply) return tl::unexpected(reply.error());
  // One line, of nearly every controller.
  const auto steps =
      reply->size() == 1 ? CountOf(reply->front()) : CountOf(Joined(*reply));
  if (!steps) {
    return tl::unexpected(MachineFault{
        .kind = MachineFault::Kind::kRefused,
        .reply = "M114 does not tell the motor steps (Count): " + Joined(*reply)});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    position_mm_[axis] = (*steps)[axis] / settings_.steps_per_mm[i];
  }
  position_mm_ = AxesOf(drawing_.kind->drive_map(), position_mm_);
  return position_mm_;
}

}  // namespace caltwin
