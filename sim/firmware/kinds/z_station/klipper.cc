#include "sim/firmware/kinds/z_station/klipper.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <sstream>

#include <fmt/format.h>

namespace caltwin {
namespace {

constexpr double kTravel_mm_s = 10;
constexpr double kHoming_s = 20;
constexpr double kClear_mm = 10;
constexpr double kTravelFlat_mm_s = 150;
constexpr double kDock_s = 5;  // In and out of the magnets, slowly.

Reply OutOfRange(const Eigen::Vector2d& place_mm, double z_mm) {
  return KlipperRefusal(fmt::format(
      "Move out of range: {:.9g} {:.9g} {:.9g}", place_mm[0], place_mm[1], z_mm));
}

std::string Upper(std::string text) {
  for (char& c : text)
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

// "Z_ADJUST=0.1", or "Z0.1" of G-code.
std::pair<std::string, std::string> WordOf(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals != std::string::npos) {
    return {Upper(text.substr(0, equals)), text.substr(equals + 1)};
  }
  return {Upper(text.substr(0, 1)), text.substr(1)};
}

std::optional<double> NumberOf(const std::map<std::string, std::string>& words,
                               const std::string& key) {
  const auto word = words.find(key);
  if (word == words.end() || word->second.empty()) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(word->second.c_str(), &end);
  return *end == '\0' && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// Names of words that are numbers, whichever the command.
constexpr std::array kNumbers = {"X",
                                 "Y",
                                 "Z",
                                 "S",
                                 "F",
                                 "Z_ADJUST",
                                 "MOVE",
                                 "PROBE_SPEED",
                                 "LIFT_SPEED",
                                 "SAMPLE_RETRACT_DIST",
                                 "SAMPLES"};

// "G1X5Y5" is three words to Klipper; names such as GET_POSITION are one.
std::string Spaced(std::string_view line) {
  const std::size_t start = line.find_first_not_of(" \t");
  const auto is_alpha = [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0;
  };
  if (start == std::string_view::npos || start + 1 >= line.size() ||
      !is_alpha(line[start]) || is_alpha(line[start + 1]) || line[start + 1] == '_') {
    return std::string(line);
  }
  std::string spaced;
  for (const char c : line) {
    if (is_alpha(c)) spaced += ' ';
    spaced += c;
  }
  return spaced;
}

double Average(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(values.size());
}

// Of an even number the mean of the two in the middle, as Klipper has it.
double Median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double Deviation(const std::vector<double>& values) {
  const double average = Average(values);
  double squares = 0;
  for (const double value : values) squares += (value - average) * (value - average);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

Reply KlipperRefusal(const std::string& text) {
  return {.lines = {"!! " + text}, .error = true};
}

Reply KlipperZ::Execute(std::string_view line) {
  std::istringstream text{Spaced(line.substr(0, line.find(';')))};
  std::string command;
  if (!(text >> command)) return {};
  command = Upper(command);
  Words words;
  for (std::string word; text >> word;) {
    auto [key, value] = WordOf(word);
    words.insert_or_assign(std::move(key), std::move(value));  // The last one counts.
  }
  for (const char* key : kNumbers) {
    const auto word = words.find(key);
    // G28 Z names an axis.
    if (word == words.end() || (command == "G28" && word->second.empty())) continue;
    if (!NumberOf(words, key)) {
      return KlipperRefusal(fmt::format(
          "Error on '{}': unable to parse {}", std::string(line), word->second));
    }
  }
  const bool moves = command == "G0" || command == "G1";
  if (moves && NumberOf(words, "F").value_or(1) <= 0) {
    return KlipperRefusal(fmt::format("Invalid speed in '{}'", line));
  }
  return Obey(command, words);
}

Reply KlipperZ::Obey(const std::string& command, const Words& words) {
  if (command == "G28") {
    const bool is_without_z =
        !words.contains("Z") && (words.contains("X") || words.contains("Y"));
    if (!is_without_z) return Home();
    now_.at_s += kHoming_s;
    return {};
  }
  if (command == "G0" || command == "G1") return Move(words);
  if (command == "SET_GCODE_OFFSET") return SetOffset(words);
  if (command == "GET_POSITION") return GetPosition();
  if (command == "CALIBRATE_Z") return CalibrateZ();
  if (command == "PROBE") return ProbeBed();
  if (command == "PROBE_ACCURACY") return Accuracy(ZTouch::kProbeOnBed, words);
  if (command == "PROBE_Z_ACCURACY") return Accuracy(ZTouch::kNozzleOnSwitch, words);
  if (command == "ATTACH_PROBE") return Dock(true);
  if (command == "DETACH_PROBE") return Dock(false);
  if (command == "BED_MESH_CALIBRATE") return CalibrateMesh();
  if (command == "BED_MESH_CLEAR") {
    mesh_mm_.clear();
    return {};
  }
  if (command == "M104" || command == "M140" || command == "M141") {
    return Heat(command, words);
  }
  if (command == "G90" || command == "G91") {
    is_relative_ = command == "G91";
    return {};
  }
  if (command == "M114") return GcodePosition();
  if (command == "G21" || command == "M400") return {};
  return KlipperRefusal(fmt::format("Unknown command:\"{}\"", command));
}

Reply KlipperZ::Heat(const std::string& command, const Words& words) {
  constexpr double kCold_c = 20, kHottest_c = 400;
  const double temp_c = NumberOf(words, "S").value_or(kCold_c);
  if (temp_c < 0 || temp_c > kHottest_c) {
    return KlipperRefusal(
        fmt::format("Requested temperature ({:.1f}) out of range (0.0:{:.1f})",
                    temp_c,
                    kHottest_c));
  }
  const char what = command == "M104" ? 'n' : command == "M140" ? 'b' : 'c';
  (what == 'n' ? now_.nozzle_c : what == 'b' ? now_.bed_c : now_.chamber_c) = temp_c;
  plant_->Heat(what, temp_c);
  return {};
}

Reply KlipperZ::Run(const std::string& macro) {
  std::istringstream lines(macro);
  for (std::string line; std::getline(lines, line);) {
    const Reply reply = Execute(line);
    if (reply.error) return reply;
  }
  return {};
}

std::optional<std::string> KlipperZ::Lacks(ZTouch touch) const {
  if (!is_homed_) return "Must home axis first";
  if (touch != ZTouch::kNozzleOnSwitch && !is_attached_) {
    return "Probe is not attached: call ATTACH_PROBE";
  }
  if (touch == ZTouch::kProbeOnBed && rests_at_mm_ && z_mm_ <= *rests_at_mm_) {
    return "Probe triggered prior to movement";
  }
  return std::nullopt;
}

Reply KlipperZ::Home() {
  const auto trigger = plant_->Touch(ZTouch::kNozzleOnSwitch, at_mm_);
  if (!trigger) return KlipperRefusal("No trigger on z after full movement");
  is_homed_ = true;
  rests_at_mm_.reset();
  zero_mm_ = *trigger - config_.position_endstop_mm;
  z_mm_ = config_.position_endstop_mm + kClear_mm;
  now_.at_s += kHoming_s;
  ++now_.homing;
  return {};
}

bool KlipperZ::IsInRange(const Eigen::Vector2d& place_mm, double z_mm) const {
  return z_mm >= config_.position_min_mm && z_mm <= config_.position_max_mm &&
         (place_mm.array() >= config_.least_mm.array()).all() &&
         (place_mm.array() <= config_.most_mm.array()).all();
}

Reply KlipperZ::Move(const Words& words) {
  if (!is_homed_) return KlipperRefusal("Must home axis first");
  const auto target_mm = [&](const char* letter, double here_mm) {
    const auto word_mm = NumberOf(words, letter);
    if (!word_mm) return here_mm;
    return is_relative_ ? here_mm + *word_mm : *word_mm;
  };
  const Eigen::Vector2d to_place_mm(target_mm("X", at_mm_[0]),
                                    target_mm("Y", at_mm_[1]));
  const double to_mm = target_mm("Z", GcodeZ_mm()) + offset_mm_ + Mesh_mm(to_place_mm);
  if (!IsInRange(to_place_mm, to_mm)) return OutOfRange(to_place_mm, to_mm);
  Travel(to_place_mm);
  now_.at_s += std::abs(to_mm - z_mm_) / kTravel_mm_s;
  z_mm_ = to_mm;
  return {};
}

std::optional<double> KlipperZ::TouchOnce(ZTouch touch, const Way& way) {
  const auto trigger = plant_->Touch(touch, at_mm_);
  if (!trigger) return std::nullopt;
  const double at_mm = *trigger - zero_mm_;
  rests_at_mm_.reset();
  now_.at_s += std::abs(z_mm_ - at_mm) / way.down_mm_s + way.up_mm / way.up_mm_s;
  z_mm_ = at_mm + way.up_mm;
  touched_.push_back({.touch = touch,
                      .place_mm = at_mm_,
                      .height_mm = at_mm,
                      .feed_mm_s = way.down_mm_s,
                      .when = now_});
  if (at_mm < config_.position_min_mm) return std::nullopt;
  return at_mm;
}

std::optional<double> KlipperZ::Touch(ZTouch touch, std::string* error) {
  z_mm_ = std::max(z_mm_, kClear_mm);
  const Way way{.down_mm_s = config_.probing_speed_mm_s,
                .up_mm_s = config_.lifting_speed_mm_s,
                .up_mm = config_.retract_mm};
  for (int attempt = 0; attempt <= config_.samples_tolerance_retries; ++attempt) {
    std::vector<double> samples;
    for (int i = 0; i < config_.samples; ++i) {
      const auto at = TouchOnce(touch, way);
      if (!at) {
        *error = "No trigger on probe after full movement";
        return std::nullopt;
      }
      samples.push_back(*at);
    }
    const auto [least, most] = std::ranges::minmax(samples);
    if (most - least > config_.samples_tolerance_mm) continue;
    return config_.takes_median ? Median(samples) : Average(samples);
  }
  *error = "Probe samples exceed samples_tolerance";
  return std::nullopt;
}

Reply KlipperZ::Accuracy(ZTouch touch, const Words& words) {
  if (const auto lacks = Lacks(touch)) return KlipperRefusal(*lacks);
  const Way way{
      .down_mm_s = NumberOf(words, "PROBE_SPEED").value_or(config_.probing_speed_mm_s),
      .up_mm_s = NumberOf(words, "LIFT_SPEED").value_or(config_.lifting_speed_mm_s),
      .up_mm = NumberOf(words, "SAMPLE_RETRACT_DIST").value_or(config_.retract_mm)};
  // PROBE_Z_ACCURACY takes what it is not told from [z_calibration], PROBE_ACCURACY
  // ten.
  const bool is_of_endstop = touch == ZTouch::kNozzleOnSwitch;
  const double wanted =
      NumberOf(words, "SAMPLES").value_or(is_of_endstop ? config_.samples : 10);
  constexpr double kMostSamples = 10'000;
  if (wanted != std::floor(wanted) || wanted > kMostSamples) {
    return KlipperRefusal(
        fmt::format("unable to parse SAMPLES={:g}: a whole number up to {:g}",
                    wanted,
                    kMostSamples));
  }
  const int samples = static_cast<int>(wanted);
  if (std::min({way.down_mm_s, way.up_mm_s, way.up_mm}) <= 0 || samples < 1) {
    return KlipperRefusal(
        "PROBE_SPEED, LIFT_SPEED, SAMPLE_RETRACT_DIST and SAMPLES must be above 0");
  }
  std::vector<double> at_mm;
  Reply reply;
  for (int i = 0; i < samples; ++i) {
    const auto at = TouchOnce(touch, way);
    if (!at) return KlipperRefusal("No trigger on probe after full movement");
    at_mm.push_back(*at);
  }
  const auto [least, most] = std::ranges::minmax(at_mm);
  reply.lines.push_back(fmt::format(
      "probe accuracy results: maximum {:.6f}, minimum {:.6f}, range {:.6f}, average "
      "{:.6f}, median {:.6f}, standard deviation {:.6f}",
      most,
      least,
      most - least,
      Average(at_mm),
      Median(at_mm),
      Deviation(at_mm)));
  return reply;
}

Reply KlipperZ::ProbeBed() {
  if (const auto lacks = Lacks(ZTouch::kProbeOnBed)) return KlipperRefusal(*lacks);
  std::string error;
  const auto at = Touch(ZTouch::kProbeOnBed, &error);
  if (!at) return KlipperRefusal(error);
  z_mm_ = touched_.back().height_mm;  // Nobody lifts it after the last sample.
  rests_at_mm_ = z_mm_;
  return {.lines = {fmt::format("Result is z={:.6f}", *at)}};
}

Reply KlipperZ::SetOffset(const Words& words) {
  double offset_mm = offset_mm_;
  for (const char* word : {"X", "Y", "X_ADJUST", "Y_ADJUST"}) {
    if (words.contains(word)) {
      return KlipperRefusal(
          fmt::format("SET_GCODE_OFFSET {} is not part of this station", word));
    }
  }
  if (const auto z = NumberOf(words, "Z")) {
    offset_mm = *z;  // Klipper does not look at Z_ADJUST beside it.
  } else if (const auto by = NumberOf(words, "Z_ADJUST")) {
    offset_mm += *by;
  }
  if (NumberOf(words, "MOVE").value_or(0) == 1) {
    if (!is_homed_) return KlipperRefusal("Must home axis first");
    const double to_mm = z_mm_ + offset_mm - offset_mm_;
    if (!IsInRange(at_mm_, to_mm)) return OutOfRange(at_mm_, to_mm);
    z_mm_ = to_mm;
  }
  offset_mm_ = offset_mm;
  return {};
}

void KlipperZ::Travel(const Eigen::Vector2d& to_mm) {
  now_.at_s += (to_mm - at_mm_).norm() / kTravelFlat_mm_s;
  at_mm_ = to_mm;
}

// A macro's path: to the dock, the probe in or out of its magnets. Whether the probe
// came along only its switch could tell.
Reply KlipperZ::Dock(bool attaches) {
  if (!is_homed_) return KlipperRefusal("Must home axis first");
  if (is_attached_ == attaches) return {};
  z_mm_ = std::max(z_mm_, kClear_mm);
  Travel(config_.dock_mm);
  now_.at_s += kDock_s;
  is_attached_ = attaches;
  return {};
}

double KlipperZ::GcodeZ_mm() const {
  return z_mm_ - offset_mm_ - Mesh_mm(at_mm_);
}

Reply KlipperZ::GcodePosition() const {
  return {
      .lines = {fmt::format(
          "X:{:.3f} Y:{:.3f} Z:{:.3f} E:0.000", at_mm_[0], at_mm_[1], GcodeZ_mm())}};
}

Reply KlipperZ::GetPosition() const {
  const std::string at = fmt::format("X:{:.6f} Y:{:.6f}", at_mm_[0], at_mm_[1]);
  // The last position of G-code, its base included; a mesh is not.
  const double gcode_mm = z_mm_ - Mesh_mm(at_mm_);
  return {.lines = {
              fmt::format("kinematic: {} Z:{:.6f}", at, z_mm_),
              fmt::format("toolhead: {} Z:{:.6f} E:0.000000", at, z_mm_),
              fmt::format("gcode: {} Z:{:.6f} E:0.000000", at, gcode_mm),
              fmt::format("gcode base: X:0.000000 Y:0.000000 Z:{:.6f} E:0.000000",
                          offset_mm_),
              fmt::format("gcode homing: X:0.000000 Y:0.000000 Z:{:.6f}", offset_mm_)}};
}

std::optional<double> KlipperZ::CarriageAtNought_mm(
    const Eigen::Vector2d& at_mm) const {
  if (!is_homed_) return std::nullopt;
  return zero_mm_ + offset_mm_ + Mesh_mm(at_mm);
}

}  // namespace caltwin
