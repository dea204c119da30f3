#include "sim/measure/import/drive_steps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// The number before a word, "16" of "16 teeth"; nullopt: none.
std::optional<double> Before(const std::string& lower, std::string_view word) {
  const std::size_t at = lower.find(word);
  return at == std::string::npos ? std::nullopt : NumberBefore(lower, at);
}

// "#define TMC2130_USTEPS_XY 16", "#define X_MICROSTEPS 32", "microsteps: 16".
std::optional<double> MicrostepsSet(const std::string& lower) {
  for (const std::string_view word : {"usteps", "microsteps"}) {
    const std::size_t at = lower.find(word);
    if (at == std::string::npos) continue;
    const bool is_setting =
        lower.starts_with("#define") || lower[at + word.size()] == ':';
    const std::size_t value = lower.find_first_of(" \t:", at);
    if (!is_setting || value == std::string::npos) continue;
    const std::vector<double> numbers = NumbersApart(
        std::string_view(lower).substr(value, lower.find("//", value) - value));
    if (!numbers.empty()) return numbers[0];
  }
  return std::nullopt;
}

double RatioIn(const Imported& imported, std::size_t axis) {
  for (const Row& row : imported.table.rows) {
    const double told_mm = row.cmd_mm[axis];
    if (row.kind == RowKind::kPosition && Known(told_mm) && told_mm > 0)
      return 1 + row.value_mm / told_mm;
  }
  return kUnknown;
}

}  // namespace

void DriveSteps::Take(const ConsoleLine& line, int number) {
  if (IsCommand(line, "m92")) {
    const auto x = WordOf(line, 'x'), y = WordOf(line, 'y');
    set_ = {x.value_or(set_[0]), y.value_or(set_[1])};
    line_ = number;
    return;
  }
  if (const auto microsteps = MicrostepsSet(line.lower)) {
    microsteps_ = *microsteps;
    return;
  }
  if (const auto microsteps = Before(line.lower, "microstep"))
    spoken_of_.push_back(*microsteps);
  teeth_ = Before(line.lower, "teeth")
               .value_or(Before(line.lower, "tooth").value_or(teeth_));
  if (line.lower.find("gt2") != std::string::npos ||
      line.lower.find("2gt") != std::string::npos) {
    pitch_mm_ = 2;
  }
  pitch_mm_ = Before(line.lower, "mm pitch").value_or(pitch_mm_);
  for (const double deg : {1.8, 0.9}) {
    const std::string word = fmt::format("{} deg", deg);
    if (line.lower.find(word) != std::string::npos) step_deg_ = deg;
  }
}

double DriveSteps::Needed(double microsteps) const {
  constexpr double kTurn_deg = 360;
  return kTurn_deg / step_deg_ * microsteps / (teeth_ * pitch_mm_);
}

void DriveSteps::Tell(Imported* imported) const {
  constexpr double kAlike = 0.01;
  const double needed = Needed(microsteps_);
  if (!Known(needed) || !(needed > 0)) return;
  std::string axes, words, remedy;
  double ratio = kUnknown, moved = kUnknown;
  for (std::size_t k = 0; k < set_.size(); ++k) {
    const double doublings = std::log2(set_[k] / needed);
    const bool is_doubled = std::abs(doublings) > 0.5 &&
                            std::abs(doublings - std::round(doublings)) < kAlike;
    // Axes that err alike are told together.
    if (!is_doubled || (Known(ratio) && set_[k] / needed != ratio)) continue;
    ratio = set_[k] / needed;
    moved = Known(moved) ? moved : RatioIn(*imported, k);
    axes += "xy"[k];
    words += fmt::format(" {}{:g}", "XY"[k], set_[k]);
    remedy += fmt::format(" {}{:g}", "XY"[k], needed);
  }
  if (axes.empty()) return;
  const double fitting = microsteps_ * ratio;
  const bool is_spoken_of = std::ranges::find(spoken_of_, fitting) != spoken_of_.end();
  imported->notes.push_back(
      {.kind = FileNote::Kind::kSetting,
       .what = "M92",
       .sentence = fmt::format(
           "M92{} of line {} is {:g} times the {:g} steps/mm that the drive needs "
           "({:g} "
           "teeth of {:g} mm, {:g} degrees a step, {:g} microsteps){}: it belongs to "
           "{:g} microsteps{}. Set M92{}, or the driver to {:g} microsteps, not both. "
           "No "
           "pulley, belt, play or lost step is to blame",
           words,
           line_,
           ratio,
           needed,
           teeth_,
           pitch_mm_,
           step_deg_,
           microsteps_,
           Known(moved) && std::abs(moved / ratio - 1) < kAlike
               ? fmt::format(", and moves are {:g} times as long as told", moved)
               : "",
           fitting,
           is_spoken_of ? ", which the text speaks of" : "",
           remedy,
           fitting),
       .place = {.line = line_, .column = 1},
       .fact = "ratio",
       .axis = axes.substr(0, 1),
       .word = "microsteps",
       .figures = {{"factor", ratio}}});
}

}  // namespace caltwin
