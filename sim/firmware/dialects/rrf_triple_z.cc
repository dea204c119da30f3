#include "sim/firmware/dialects/rrf_triple_z.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/link/gcode_frame.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr double kTravel_mm_s = 150;
constexpr double kLift_mm_s = 20;
constexpr double kAcceleration_mm_s2 = 3000;
constexpr double kDive_mm = 5;  // M558 H: the way down to a touch.
constexpr double kHoming_s = 25;
constexpr double kSpare_mm = 5;    // Of a screw beyond where the bed meets the nozzle.
constexpr double kSettle_s = 0.2;  // M558 R.

std::optional<double> NumberOf(const GcodeCommand& command, char letter) {
  const GcodeWord* word = command.Find(letter);
  if (word == nullptr || word->kind != GcodeWord::Kind::kNumber) return std::nullopt;
  return std::isfinite(word->number) ? std::optional(word->number) : std::nullopt;
}

Reply Refusal(const std::string& text) {
  return {.lines = {"Error: " + text}, .error = true};
}

double MoveTime_s(double length_mm, double feed_mm_s) {
  return length_mm == 0 ? 0 : length_mm / feed_mm_s + feed_mm_s / kAcceleration_mm_s2;
}

// The numbers behind a letter, "Z0:1:2"; nullopt where the letter is not there.
std::optional<std::vector<double>> ListOf(std::string_view line, char letter) {
  const std::size_t at = line.find(letter, 1);  // The command's own letter is no word.
  if (at == std::string_view::npos) return std::nullopt;
  std::vector<double> numbers;
  const char* from = line.data() + at + 1;
  const char* const end = line.data() + line.size();
  for (;;) {
    double number = 0;
    const auto read = std::from_chars(from, end, number);
    if (read.ec != std::errc() || !std::isfinite(number)) return numbers;
    numbers.push_back(number);
    if (read.ptr == end || *read.ptr != ':') return numbers;
    from = read.ptr + 1;
  }
}

bool Begins(std::string_view line, std::string_view command) {
  return line.starts_with(command) &&
         (line.size() == command.size() || line[command.size()] == ' ');
}

}  // namespace

RrfTripleZ::RrfTripleZ(const RrfTripleZOptions& options, TripleZPlant* plant)
    : options_(options), plant_(plant) {}

Vec3<double> RrfTripleZ::raised_mm() const {
  Vec3<double> raised_mm = height_mm_;
  for (int i = 0; i < kNumScrews; ++i) raised_mm[i] += z_mm_[0] - options_.top_mm;
  return (raised_mm * options_.steps_per_mm).array().round() / options_.steps_per_mm;
}

Reply RrfTripleZ::Execute(std::string_view line) {
  GcodeLine parsed;
  try {
    // Their lists, Z0:1:2, are no numbers.
    const std::string text = ReadGcodeFrame(line).text;
    if (Begins(text, "M584")) return SetDrivers(text);
    if (Begins(text, "M671")) return SetScrews(text);
    parsed = ParseGcode(line);
  } catch (const InputError& error) {
    return Refusal(error.what());
  }
  if (parsed.is_meta) return Refusal("meta commands are not known here");
  Reply reply;
  for (const GcodeCommand& command : parsed.commands) {
    const Reply part = Obey(command);
    reply.lines.insert(reply.lines.end(), part.lines.begin(), part.lines.end());
    reply.error = reply.error || part.error;
  }
  return reply;
}

Reply RrfTripleZ::Obey(const GcodeCommand& command) {
  if (command.Is('G', 28)) return Home();
  if (command.Is('G', 30)) return Probe(command);
  if (command.Is('G', 0) || command.Is('G', 1)) return Move(command);
  if (command.Is('G', 92)) return SetPosition(command);
  if (command.Is('M', 114)) return Position();
  if (command.Is('M', 115)) {
    return {
        .lines = {"FIRMWARE_NAME: RepRapFirmware for caltwin FIRMWARE_VERSION: 3.6.1"}};
  }
  if (command.Is('M', 119)) {
    return {.lines = {fmt::format(
                "Endstops - X: not stopped, Y: not stopped, Z: {}, "
                "Z probe: not stopped",
                height_mm_.minCoeff() <= 0 ? "at min stop" : "not stopped")}};
  }
  if (command.Is('M', 92)) {
    const double to = NumberOf(command, 'Z').value_or(options_.steps_per_mm);
    if (to <= 0) return Refusal("M92: steps/mm must be above 0");
    options_.steps_per_mm = to;
    return {.lines = {fmt::format("Steps/mm: Z: {:.3f}", options_.steps_per_mm)}};
  }
  if (command.Is('M', 400) || command.Is('G', 90) || command.Is('G', 21)) return {};
  return Refusal(fmt::format("{} is not known to this machine", command.Name()));
}

Reply RrfTripleZ::Home() {
  is_homed_ = true;
  ++homings_;
  is_split_ = false;
  at_mm_.setZero();
  height_mm_.setZero();
  z_mm_.setConstant(options_.top_mm);
  points_.clear();
  time_s_ += kHoming_s;
  return {};
}

Reply RrfTripleZ::Move(const GcodeCommand& command) {
  if (!is_homed_) return Refusal("G0/G1: insufficient axes homed");
  const Eigen::Vector2d to_mm(NumberOf(command, 'X').value_or(at_mm_[0]),
                              NumberOf(command, 'Y').value_or(at_mm_[1]));
  Vec3<double> z_mm = z_mm_;
  if (const auto z = NumberOf(command, 'Z')) {
    if (is_split_) {
      z_mm[0] = *z;
    } else {
      z_mm.setConstant(*z);
    }
  }
  if (is_split_) {
    const bool is_placed = (command.Find('U') == nullptr || are_placed_[1]) &&
                           (command.Find('V') == nullptr || are_placed_[2]);
    if (!is_placed) return Refusal("G0/G1: insufficient axes homed");
    z_mm[1] = NumberOf(command, 'U').value_or(z_mm[1]);
    z_mm[2] = NumberOf(command, 'V').value_or(z_mm[2]);
  } else if (command.Find('U') != nullptr || command.Find('V') != nullptr) {
    return Refusal("G0/G1: there are no axes U and V before M584");
  }
  const Vec3<double> height_mm = height_mm_ - (z_mm - z_mm_);
  const bool is_inside = (to_mm.array() >= 0).all() &&
                         (to_mm.array() <= options_.most_mm.array()).all() &&
                         height_mm.minCoeff() >= -kSpare_mm &&
                         height_mm.maxCoeff() <= options_.top_mm + kSpare_mm;
  if (!is_inside) return Refusal("G0/G1: target position outside machine limits");
  time_s_ += MoveTime_s((to_mm - at_mm_).norm(), kTravel_mm_s) +
             MoveTime_s((z_mm - z_mm_).cwiseAbs().maxCoeff(), kLift_mm_s);
  at_mm_ = to_mm;
  z_mm_ = z_mm;
  height_mm_ = height_mm;
  return {};
}

Reply RrfTripleZ::Probe(const GcodeCommand& command) {
  if (!is_homed_) return Refusal("G30: insufficient axes homed");
  if (is_split_) return Refusal("G30: the drivers of Z are not joined");
  const Eigen::Vector2d to_mm(NumberOf(command, 'X').value_or(at_mm_[0]),
                              NumberOf(command, 'Y').value_or(at_mm_[1]));
  for (const char letter : {'X', 'Y', 'Z', 'P', 'S'}) {
    if (command.Find(letter) != nullptr && !NumberOf(command, letter)) {
      return Refusal(fmt::format("G30: {} is no number", letter));
    }
  }
  if ((to_mm.array() < 0).any() || (to_mm.array() > options_.most_mm.array()).any()) {
    return Refusal("G30: probe point is outside the travel of X and Y");
  }
  const auto height = plant_->Touch(raised_mm(), to_mm[0], to_mm[1]);
  if (!height) return Refusal("Probe was not triggered during probing move");
  const double stopped_mm =
      std::round(*height * options_.steps_per_mm) / options_.steps_per_mm + 0.0;
  const double from_mm = stopped_mm + kDive_mm;
  const Vec3<double> told_mm = raised_mm();
  time_s_ += MoveTime_s((to_mm - at_mm_).norm(), kTravel_mm_s) +
             MoveTime_s(std::abs(z_mm_[0] - from_mm), kLift_mm_s) +
             kDive_mm / options_.probe_mm_s + kSettle_s;
  touched_.push_back({.at_mm = to_mm,
                      .stopped_mm = stopped_mm,
                      .raised_mm = told_mm,
                      .steps_per_mm = options_.steps_per_mm,
                      .feed_mm_s = options_.probe_mm_s,
                      .at_s = time_s_,
                      .homing = homings_});
  time_s_ += MoveTime_s(kDive_mm, kLift_mm_s);
  at_mm_ = to_mm;
  height_mm_.array() -= from_mm - z_mm_[0];
  z_mm_.setConstant(from_mm);
  const auto point = NumberOf(command, 'P');
  const auto factors = NumberOf(command, 'S');
  if (!point) {
    return {.lines = {fmt::format("Stopped at height {:.3f} mm", stopped_mm)}};
  }
  if (*point == 0) points_.clear();
  points_.push_back({to_mm, stopped_mm});
  if (factors && *factors >= 0) return Adjust();
  return {};
}

Reply RrfTripleZ::Adjust() {
  const auto corrections = LevelScrews(options_.pivots_mm, points_);
  const std::size_t count = points_.size();
  points_.clear();
  if (!corrections) return Refusal("Bed calibration: 3 points apart are needed");
  const Vec3<double> raise_mm = corrections->raise_mm;
  if (raise_mm.cwiseAbs().maxCoeff() > options_.largest_mm) {
    return Refusal(fmt::format(
        "Some computed corrections exceed configured limit of {:.2f}mm: {:.3f} {:.3f} "
        "{:.3f}",
        options_.largest_mm,
        raise_mm[0],
        raise_mm[1],
        raise_mm[2]));
  }
  height_mm_ += raise_mm;
  time_s_ += MoveTime_s(raise_mm.cwiseAbs().maxCoeff(), kLift_mm_s);
  return {
      .lines = {fmt::format(
          "Leadscrew adjustments made: {:.3f} {:.3f} {:.3f}, points used {}, (mean, "
          "deviation) before ({:.3f}, {:.3f}) after ({:.3f}, {:.3f})",
          raise_mm[0],
          raise_mm[1],
          raise_mm[2],
          count,
          corrections->mean_before_mm,
          corrections->deviation_before_mm,
          corrections->mean_after_mm,
          corrections->deviation_after_mm)}};
}

Reply RrfTripleZ::SetPosition(const GcodeCommand& command) {
  constexpr std::string_view kLetters = "ZUV";
  for (int i = 0; i < kNumScrews; ++i) {
    const auto to = NumberOf(command, kLetters[static_cast<std::size_t>(i)]);
    if (!to) continue;
    if (is_split_) {
      z_mm_[i] = *to;
      are_placed_[static_cast<std::size_t>(i)] = true;
    } else if (i == 0) {
      z_mm_.setConstant(*to);
    }
  }
  return {};
}

Reply RrfTripleZ::Position() const {
  std::string text =
      fmt::format("X:{:.3f} Y:{:.3f} Z:{:.3f}", at_mm_[0], at_mm_[1], z_mm_[0]);
  if (is_split_) text += fmt::format(" U:{:.3f} V:{:.3f}", z_mm_[1], z_mm_[2]);
  text += " E:0.000 Count";
  for (int i = 0; i < kNumScrews; ++i) {
    text += fmt::format(" {}", std::lround(height_mm_[i] * options_.steps_per_mm));
  }
  return {.lines = {text}};
}

Reply RrfTripleZ::SetDrivers(std::string_view line) {
  const auto z = ListOf(line, 'Z'), u = ListOf(line, 'U'), v = ListOf(line, 'V');
  const bool joins = z == std::vector<double>{0, 1, 2} && !u && !v;
  const bool splits = z == std::vector<double>{0} && u == std::vector<double>{1} &&
                      v == std::vector<double>{2};
  if (!joins && !splits) return Refusal("M584: Z0 U1 V2 P5, or Z0:1:2 P3, here");
  is_split_ = splits;
  // New axes stand at 0 and are not homed before G92 says where they are; drivers that
  // join an axis stand where it does.
  are_placed_ = {true, joins, joins};
  for (int i = 1; i < kNumScrews; ++i) z_mm_[i] = splits ? 0 : z_mm_[0];
  return {};
}

Reply RrfTripleZ::SetScrews(std::string_view line) {
  const auto x = ListOf(line, 'X'), y = ListOf(line, 'Y'), s = ListOf(line, 'S');
  if (!x && !y && !s) {
    const Pivots<double>& at = options_.pivots_mm;
    return {.lines = {fmt::format(
                "leadscrews at ({:.1f}, {:.1f}), ({:.1f}, {:.1f}), ({:.1f}, {:.1f}), "
                "maximum correction {:.2f}mm",
                at[0][0],
                at[0][1],
                at[1][0],
                at[1][1],
                at[2][0],
                at[2][1],
                options_.largest_mm)}};
  }
  if (x || y) {
    if (!x || !y || x->size() != kNumScrews || y->size() != kNumScrews) {
      return Refusal("M671: X and Y need three numbers each, X20:215:20");
    }
    Pivots<double> pivots_mm;
    for (std::size_t i = 0; i < kNumScrews; ++i) pivots_mm[i] = {(*x)[i], (*y)[i]};
    if (TriangleShape(pivots_mm) < kFlattestTriangle) {
      return Refusal("M671: the leadscrews stand nearly in one line");
    }
    options_.pivots_mm = pivots_mm;
  }
  if (s && (s->size() != 1 || !(s->front() > 0))) {
    return Refusal("M671: S needs a number above 0");
  }
  if (s) options_.largest_mm = s->front();
  return {};
}

}  // namespace caltwin
