#include "sim/measure/import/grbl_story.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr const char* kAxisLetters = "xyz";

// "1.000,2.000,3.000" behind a key; nullopt: it does not stand there.
std::optional<std::array<double, 3>> TripleAfter(const std::string& lower,
                                                 std::string_view key) {
  const std::size_t at = lower.find(key);
  if (at == std::string::npos) return std::nullopt;
  std::array<double, 3> numbers{};
  std::string_view rest = std::string_view(lower).substr(at + key.size());
  for (double& number : numbers) {
    const std::size_t end = std::min(rest.size(), rest.find_first_of(",|:>]"));
    const auto value = NumberOf(rest.substr(0, end));
    if (!value) return std::nullopt;
    number = *value;
    rest.remove_prefix(std::min(rest.size(), end + 1));
  }
  return numbers;
}

bool Has(const ConsoleLine& line, std::string_view word) {
  return (" " + line.lower + " ").find(" " + std::string(word) + " ") !=
         std::string::npos;
}

}  // namespace

void GrblStory::Take(const ConsoleLine& line) {
  if (Has(line, "g90")) is_relative_ = false;
  if (Has(line, "g91")) is_relative_ = true;
  TakeExtents(line);
  idle_ms_ = GrblSetting(line, 1).value_or(idle_ms_);
  constexpr std::array<std::string_view, 4> kPauses = {
      "g4", "pauses", "lifts", "dwells"};
  has_pauses_ |= std::ranges::any_of(
      kPauses, [&](std::string_view word) { return Has(line, word); });
  for (std::size_t k = 0; k < 3; ++k) {
    const auto steps = GrblSetting(line, 100 + static_cast<int>(k));
    if (steps && SettingsInForce::kSteps_per_mm.Contains(*steps))
      steps_per_mm_[k] = *steps;
  }
  if (const auto zero_mm = TripleAfter(line.lower, "[g54:")) work_zero_mm_ = *zero_mm;
  if (line.lower.find("g38.") != std::string::npos) {
    TakeProbingMove(line);
  } else if (Has(line, "g10") && Has(line, "l20")) {
    zero_mm_ = WordOf(line, 'z').value_or(kUnknown);
  } else if (Has(line, "g0") || Has(line, "g1") || Has(line, "g00") ||
             Has(line, "g01")) {
    TakeMove(line);
  } else if (line.lower.starts_with("[prb:")) {
    TakeProbing(line);
  } else if (line.lower.find("mpos:") != std::string::npos) {
    TakeStatus(line);
  }
}

void GrblStory::TakeProbingMove(const ConsoleLine& line) {
  std::size_t num = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value_mm = WordOf(line, kAxisLetters[k]);
    if (!value_mm) continue;
    is_probed_[k] = true;
    to_mm_[k] = kUnknown;
    ++num;
    probed_axis_ = k;
    probed_sense_ = std::copysign(1.0, *value_mm);
    probed_to_mm_ = is_relative_ ? kUnknown : *value_mm + work_zero_mm_[k];
  }
  if (num != 1) probed_sense_ = 0;
  probing_mm_min_ = WordOf(line, 'f').value_or(kUnknown);
}

void GrblStory::TakeMove(const ConsoleLine& line) {
  probed_sense_ = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    // WordOf needs a word before the letter: "g91 x1".
    const auto value_mm = WordOf(line, kAxisLetters[k]);
    if (!value_mm) continue;
    told_mm_[k] += is_relative_ ? *value_mm : kUnknown;
    since_probe_mm_[k] += is_relative_ ? *value_mm : kUnknown;
    to_mm_[k] = is_relative_ ? kUnknown : *value_mm;
  }
}

void GrblStory::TakeProbing(const ConsoleLine& line) {
  constexpr double kLeast_mm = 3;
  const auto at = TripleAfter(line.lower, "[prb:");
  if (!at) return;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool is_told = !is_probed_[k] && std::abs(since_probe_mm_[k]) >= kLeast_mm;
    if (is_told && Known(probe_[k])) {
      probings_.push_back({k, since_probe_mm_[k], (*at)[k] - probe_[k], (*at)[k]});
    }
    if (Known(to_mm_[k]))
      places_.push_back({k, to_mm_[k] + work_zero_mm_[k], (*at)[k], (*at)[k]});
  }
  // What is told in absolute places lies beyond the contact.
  if (Known(probed_to_mm_) && probed_sense_ != 0)
    probed_sense_ = std::copysign(1.0, probed_to_mm_ - (*at)[probed_axis_]);
  probe_ = *at;
  touch_mm_ = (*at)[2];
  since_probe_mm_ = {};
  is_probed_ = {};
}

void GrblStory::TakeStatus(const ConsoleLine& line) {
  const auto at_mm = TripleAfter(line.lower, "mpos:");
  if (!at_mm) return;
  TakeRest(*at_mm);
  for (std::size_t k = 0; k < 3; ++k) {
    const bool is_moved =
        Known(reported_mm_[k]) && Known(told_mm_[k]) && told_mm_[k] != 0;
    if (is_moved) {
      moves_.push_back({k, told_mm_[k], (*at_mm)[k] - reported_mm_[k], (*at_mm)[k]});
    }
  }
  reported_mm_ = *at_mm;
  told_mm_ = {};
  const auto zero_mm = TripleAfter(line.lower, "wco:");
  if (zero_mm && Known(zero_mm_) && Known(touch_mm_)) {
    zeros_mm_.push_back((*zero_mm)[2] + zero_mm_ - touch_mm_);
    zero_mm_ = touch_mm_ = kUnknown;
  }
}

// Where it stands, the first time after it touched.
void GrblStory::TakeRest(const std::array<double, 3>& at_mm) {
  constexpr double kSame_mm = 2e-3;
  const bool was_probed = probed_sense_ != 0 && Known(probe_[probed_axis_]);
  for (std::size_t k = 0; was_probed && k < 3; ++k) {
    // Another zero than the report's.
    if (k != probed_axis_ && std::abs(at_mm[k] - probe_[k]) > kSame_mm) return;
  }
  if (was_probed && !is_probed_[probed_axis_])
    beyond_mm_.push_back((at_mm[probed_axis_] - probe_[probed_axis_]) * probed_sense_);
  probed_sense_ = 0;
}

// "X 0.000 mm 91.486 mm 91.486 mm" of a sender, "probed 3/12> 2.401 0.000 0.006".
void GrblStory::TakeExtents(const ConsoleLine& line) {
  std::vector<double> numbers;
  const std::size_t mark = line.lower.find("> ");
  const bool is_touch = line.lower.starts_with("probed ") && mark != std::string::npos;
  for (const TextLine& rest :
       LinesOf(std::string_view(line.lower).substr(is_touch ? mark + 2 : 0))) {
    for (const CsvField& word : rest.words) {
      if (const auto number = NumberOf(word.text)) numbers.push_back(*number);
    }
  }
  if (numbers.size() != 3) return;
  for (std::size_t k = 0; k < 2; ++k) {
    if (is_touch) {
      touched_[k] = std::max(touched_[k], numbers[k]);
    } else if (line.lower.starts_with(std::string(1, kAxisLetters[k]) + " ") &&
               line.lower.ends_with("mm")) {
      program_mm_[k] = numbers[2];
    }
  }
}

void GrblStory::TellExtents(Imported* imported) const {
  constexpr double kAlike = 0.01;
  for (std::size_t k = 0; k < 2; ++k) {
    const double factor = touched_[k] / program_mm_[k];
    if (!Known(factor) || std::abs(MmFromInch(factor) - 1) > kAlike) return;
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "The map ends at {:g} and {:g}, the program at {:g} and {:g} mm: 25.4 times "
           "as far. The touches are reported in inches and taken for millimetres, and "
           "so "
           "are the heights. Set the controller to report millimetres ($13=0), then "
           "probe "
           "again",
           touched_[0],
           touched_[1],
           program_mm_[0],
           program_mm_[1]),
       .fact = "known_ratio",
       .word = "inches",
       .figures = {{"factor", touched_[0] / program_mm_[0]}}});
}

void GrblStory::Tell(Imported* imported) const {
  TellExtents(imported);
  TellUnit(imported);
  TellZero(imported);
  TellRest(imported);
  TellSteps(imported);
  TellPlaces(imported);
}

void GrblStory::TellIdle(Imported* imported) const {
  constexpr double kAlwaysOn_ms = 255;
  constexpr std::size_t kFewest = 4;
  const std::vector<Row>& rows = imported->table.rows;
  if (!has_pauses_ || !Known(idle_ms_) || idle_ms_ >= kAlwaysOn_ms ||
      rows.size() < kFewest) {
    return;
  }
  const double change_mm = rows.back().value_mm - rows.front().value_mm;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const bool is_one_place = std::ranges::equal(
        rows[i].cmd_mm, rows[0].cmd_mm, [](double one, double other) {
          return one == other || (!Known(one) && !Known(other));
        });
    const double step_mm = rows[i].value_mm - rows[i - 1].value_mm;
    if (!is_one_place || step_mm * change_mm <= 0) return;
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "The motors are switched off {:g} ms after every move ($1={:g}), and what "
           "was read drifts with every pause: a weight, a spring or a belt pulls the "
           "axis while it is without current. $1=255 keeps them on. Steps/mm and belts "
           "are not in question",
           idle_ms_,
           idle_ms_)});
}

void GrblStory::TellUnit(Imported* imported) const {
  constexpr double kAlike = 0.03;
  for (const Reported& one : probings_) {
    const double factor = one.moved_mm / one.told_mm;
    if (!Known(factor) || std::abs(MmFromInch(factor) - 1) > kAlike) continue;
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "settings",
         .sentence = fmt::format("After {:.4g} mm in {} the probe's report changes by "
                                 "{:.4g}: the controller "
                                 "reports in inches ($13=1), while the program's moves "
                                 "are in millimetres. Set "
                                 "$13=0, or the sender to inches, and probe again: a "
                                 "plate's thickness and a "
                                 "zero computed from both units at once are wrong",
                                 one.told_mm,
                                 "XYZ"[one.axis],
                                 one.moved_mm),
         .fact = "known_ratio",
         .axis = std::string(1, kAxisLetters[one.axis]),
         .word = "inches",
         .figures = {{"factor", factor}}});
    return;
  }
}

void GrblStory::TellZero(Imported* imported) const {
  constexpr double kLeast_mm = 0.005, kSure = 4;
  if (zeros_mm_.size() < 2) return;
  double mean_mm = 0, squares_mm2 = 0;
  const auto num = static_cast<double>(zeros_mm_.size());
  for (const double zero_mm : zeros_mm_) mean_mm += zero_mm / num;
  for (const double zero_mm : zeros_mm_) squares_mm2 += std::pow(zero_mm - mean_mm, 2);
  const double sd_mm = std::sqrt(squares_mm2 / (num - 1));
  if (std::abs(mean_mm) < kLeast_mm || std::abs(mean_mm) < kSure * sd_mm) return;
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "firmware",
       .sentence = fmt::format(
           "The zero of Z is {:.0f} um {} the touch, {} times alike: it was set where "
           "the "
           "axis came to rest, not where it touched (G10 L20 takes the present place). "
           "Use the position of the [PRB] report; probe and axis are in order",
           std::abs(UmFromMm(mean_mm)),
           mean_mm < 0 ? "below" : "above",
           zeros_mm_.size()),
       .fact = "offset",
       .axis = "z",
       .word = "zero",
       .figures = {
           {"change_um", UmFromMm(mean_mm), UmFromMm(sd_mm) / std::sqrt(num)}}});
}

}  // namespace caltwin
