#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/series.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

void Tell(const std::string& reason, const std::string& sentence, Facts* facts) {
  if (facts->not_the_machine.reason.empty())
    facts->not_the_machine = {reason, sentence};
}

std::string Label(const Row& row) {
  std::string lower = row.extra.empty() ? "" : row.extra.front();
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return lower;
}

// Expected 0, read 8.00 and again 8.00: a thickness that nobody took off.
void AddZeroOffset(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 0.3, kSure = 10;
  std::map<int, std::vector<double>> off_mm;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    if (row->kind != RowKind::kPosition || axis < 0 || !row->home.empty()) return;
    const auto k = static_cast<std::size_t>(axis);
    if (row->cmd_mm[k] != 0 || (Known(row->dir[k]) && row->dir[k] != 0)) return;
    off_mm[axis].push_back(row->value_mm);
  }
  for (const auto& [axis, values_mm] : off_mm) {
    const Average average = AverageOf(values_mm);
    if (values_mm.size() < 2 || std::abs(average.mean) < kLeast_mm ||
        std::abs(average.mean) < kSure * average.sd) {
      continue;
    }
    Fact fact{.id = "offset",
              .axis = kAxisNames[static_cast<std::size_t>(axis)],
              .word = "zero",
              .figures = {{"change_um",
                           UmFromMm(average.mean),
                           UmFromMm(average.sd) / std::sqrt(average.num)}},
              .is_answer = true};
    fact.sentence = fmt::format(
        "The zero of {} is off by {}, the same each time: a constant (the thickness of "
        "a plate "
        "or the radius of a tip that the routine does not take off, another work "
        "offset). "
        "Enter it; scale and squareness are not in question",
        "XYZ"[axis],
        WithSd(average.mean, average.sd, "mm"));
    Tell("work_offset", fact.sentence, facts);
    facts->all.push_back(std::move(fact));
  }
}

// The same place touched by one tool and the next.
void AddTools(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 0.2;
  std::map<std::string, std::vector<double>> tools;
  std::vector<std::string> names;
  for (const Row* row : rows) {
    if (row->kind != RowKind::kTouch || !row->setup.starts_with("table")) return;
    if (!tools.contains(row->setup)) names.push_back(row->setup);
    tools[row->setup].push_back(row->value_mm);
  }
  if (names.size() < 2) return;
  const double change_mm =
      AverageOf(tools[names[1]]).mean - AverageOf(tools[names[0]]).mean;
  if (std::abs(change_mm) < kLeast_mm) return;
  Fact fact{.id = "offset",
            .word = "tool",
            .figures = {{"change_um", UmFromMm(change_mm)}},
            .is_answer = true};
  fact.sentence = fmt::format(
      "After the change of tool the same place is found {:.3f} mm {}: the second tool "
      "is "
      "{:.3f} mm {} than the first, and the zero belongs to the first. Enter the "
      "difference "
      "as tool length (G43.1 Z{:.3f}); the machine is in order",
      std::abs(change_mm),
      change_mm > 0 ? "higher" : "lower",
      std::abs(change_mm),
      change_mm > 0 ? "longer" : "shorter",
      change_mm);
  Tell("reference_tool", fact.sentence, facts);
  facts->all.push_back(std::move(fact));
}

// Outside too large, inside too small by as much: walls, not axes.
void AddSides(const Rows& rows, Facts* facts) {
  std::vector<double> outside_mm, inside_mm;
  for (const Row* row : rows) {
    const std::string& side = row->setup;
    const bool is_out =
        side == "outside" || side == "outer" || side == "external" || side == "boss";
    const bool is_in =
        side == "inside" || side == "inner" || side == "internal" || side == "hole";
    if (!is_out && !is_in) return;
    (is_out ? outside_mm : inside_mm).push_back(row->value_mm);
  }
  if (outside_mm.size() < 2 || inside_mm.size() < 2) return;
  const Average out = AverageOf(outside_mm), in = AverageOf(inside_mm);
  constexpr double kSure = 4, kAlike = 0.5;
  const bool is_opposite = out.mean * in.mean < 0 &&
                           std::abs(out.mean) > kSure * out.sd &&
                           std::abs(in.mean) > kSure * in.sd;
  if (!is_opposite ||
      std::abs(out.mean + in.mean) > kAlike * std::abs(out.mean - in.mean))
    return;
  const std::string sentence = fmt::format(
      "Outside {:+.2f} mm, inside {:+.2f} mm, at every length alike: walls are {:.2f} "
      "mm too {} "
      "a side. The scale of the axes is right; leave steps/mm and set flow, line width "
      "or XY "
      "compensation in the slicer",
      out.mean,
      in.mean,
      std::abs(out.mean - in.mean) / 4,
      out.mean > 0 ? "thick" : "thin");
  Tell("slicer", sentence, facts);
}

// A correction whose error is twice that without it: added where it should be taken
// off.
void AddDoubledCorrection(const Rows& rows, Facts* facts) {
  std::map<std::string, std::map<std::string, double>> series;
  std::vector<std::string> names;
  for (const Row* row : rows) {
    if (row->home.empty()) return;
    if (!series.contains(row->campaign)) names.push_back(row->campaign);
    series[row->campaign][row->home] = row->value_mm;
  }
  constexpr std::size_t kFewest = 5;
  if (names.size() != 2) return;
  double xx = 0, xy = 0, yy = 0;
  std::size_t num = 0;
  for (const auto& [home, without_mm] : series[names[0]]) {
    const auto with = series[names[1]].find(home);
    if (with == series[names[1]].end()) continue;
    xx += without_mm * without_mm;
    xy += without_mm * with->second;
    yy += with->second * with->second;
    ++num;
  }
  constexpr double kAlike = 0.15, kLeft = 0.05;
  if (num < kFewest || xx == 0) return;
  const double factor = xy / xx;
  if (std::abs(factor - 2) > kAlike || yy - xy * factor > kLeft * yy) return;
  Tell("firmware",
       fmt::format(
           "'{}' is {:.2f} times '{}' at every homing: the correction is applied with "
           "the wrong sign (e + e in place of e - e). Switch it off, or turn its sign; "
           "what it corrects is as good as before",
           names[1],
           factor,
           names[0]),
       facts);
}

// Each homing adds the same amount, to a hundredth: no part slips so evenly.
void AddAddedConstant(const Rows& rows, Facts* facts) {
  constexpr std::size_t kFewest = 5;
  constexpr double kLeastStep_mm = 0.1, kEven = 0.02;
  if (rows.size() < kFewest) return;
  std::vector<double> steps_mm;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i]->home.empty() || rows[i]->home == rows[i - 1]->home) return;
    steps_mm.push_back(rows[i]->value_mm - rows[i - 1]->value_mm);
  }
  const Average step = AverageOf(steps_mm);
  if (std::abs(step.mean) < kLeastStep_mm || step.sd > kEven * std::abs(step.mean))
    return;
  Tell(
      "firmware",
      fmt::format(
          "Each homing adds {:.3f} mm, to {:.0f} um: a coupling that slips or a switch "
          "that scatters does not do it so evenly. The controller applies a constant "
          "(HOME_OFFSET, a home position) again at every homing. Home once a session, "
          "or update",
          step.mean,
          UmFromMm(step.sd)),
      facts);
}

// The same size made twice and millimetres apart: no scale explains it.
void AddContradictingSizes(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 1, kRight = 0.01;
  std::map<std::tuple<std::string, int, long>, Rows> sizes;
  int num_right = 0;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    if (row->kind != RowKind::kPosition || axis < 0 || row->flag == kMoveFlag) return;
    const double at_mm = row->cmd_mm[static_cast<std::size_t>(axis)];
    if (!(at_mm > 0) || (Known(row->dir[static_cast<std::size_t>(axis)]))) return;
    sizes[{row->campaign, axis, std::lround(at_mm * 100)}].push_back(row);
    num_right += std::abs(row->value_mm) < kRight * at_mm ? 1 : 0;
  }
  for (const auto& [key, same] : sizes) {
    const auto [low, high] = std::ranges::minmax(same, {}, &Row::value_mm);
    if (same.size() < 2 || high->value_mm - low->value_mm < kLeast_mm || num_right < 2)
      continue;
    Fact fact{.id = "contradiction",
              .axis = kAxisNames[static_cast<std::size_t>(std::get<int>(key))],
              .figures = {{"apart_um", UmFromMm(high->value_mm - low->value_mm)}},
              .rows = {low->row, high->row},
              .is_answer = true};
    fact.sentence = fmt::format(
        "Two parts of the same size ({:g} mm) are {:.3g} mm apart while other sizes "
        "are right: "
        "no scale of {} does that. The files or slicer settings of the short ones "
        "differ, or "
        "the axis stalls now and then; leave steps/mm. Look at the sliced height first",
        static_cast<double>(std::get<long>(key)) / 100,
        high->value_mm - low->value_mm,
        "XYZ"[std::get<int>(key)]);
    const std::string name = fmt::format("scale.{}", fact.axis);
    facts->not_determined.push_back(name);
    facts->cannot.push_back(fmt::format(
        "steps/mm of {}: its sizes contradict each other", "XYZ"[std::get<int>(key)]));
    // The bad ones share a word that the good ones lack.
    if (Label(*low).find("slicer") != std::string::npos)
      Tell("slicer", fact.sentence, facts);
    std::erase_if(facts->all, [&](const Fact& other) {
      return other.axis == fact.axis &&
             (other.id == "scale" || other.id == "known_ratio" || other.id == "offset");
    });
    facts->all.push_back(std::move(fact));
    return;
  }
}

// One run drifts evenly, another at the same place under another setting does not.
void AddDriftBySetting(const Rows& rows, Facts* facts) {
  const Fact* drift = facts->Find("drift");
  if (drift == nullptr || drift->rows.empty()) return;
  const auto settings_of = [&](std::int64_t number) {
    for (const Row* row : rows) {
      if (row->row == number) return row->settings;
    }
    return std::string();
  };
  const std::string drifting = settings_of(drift->rows.front());
  if (!drifting.starts_with("microsteps_")) return;
  std::vector<double> others_mm;
  for (const Row* row : rows) {
    if (row->settings.starts_with("microsteps_") && row->settings != drifting) {
      others_mm.push_back(row->value_mm);
    }
  }
  constexpr std::size_t kFewest = 6;
  if (others_mm.size() < kFewest) return;
  const auto [low, high] = std::ranges::minmax(others_mm);
  if (UmFromMm(high - low) > 0.3 * std::abs(drift->figures[0].value)) return;
  Tell("firmware",
       fmt::format(
           "The touches drift in equal parts with {} and not with the other setting at "
           "the same place: no warming and no slack, but steps lost in counting at the "
           "trigger, at the higher step rate. Use fewer microsteps, or probe slower",
           drifting.substr(0, 10) + " " + drifting.substr(11)),
       facts);
}

// A map that climbs in the order it was probed, and touches of the same places that do
// not.
void AddClimbingMap(const Rows& rows, Facts* facts) {
  constexpr std::size_t kFewest = 5;
  constexpr double kLeast_mm = 0.2;
  std::map<std::pair<long, long>, const Row*> first;
  std::size_t num_rising = 0;
  double rise_mm = 0;
  std::vector<double> off_mm, again_mm;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row* row = rows[i];
    if (row->kind != RowKind::kTouch || !Known(row->cmd_mm[0]) ||
        !Known(row->cmd_mm[1]))
      return;
    const auto [at, is_new] = first.try_emplace(
        {std::lround(100 * row->cmd_mm[0]), std::lround(100 * row->cmd_mm[1])}, row);
    if (is_new) {
      if (i > 0 && row->value_mm > rows[i - 1]->value_mm - 0.05) ++num_rising;
      rise_mm = row->value_mm - rows.front()->value_mm;
      continue;
    }
    off_mm.push_back(at->second->value_mm - row->value_mm);
    again_mm.push_back(row->value_mm);
  }
  if (first.size() < kFewest || off_mm.size() < 2 || num_rising + 1 < first.size())
    return;
  const auto [low, high] = std::ranges::minmax(again_mm);
  const double most_mm = *std::ranges::max_element(off_mm);
  if (rise_mm < kLeast_mm || most_mm < kLeast_mm || high - low > 0.2 * most_mm) return;
  Tell("firmware",
       fmt::format(
           "The map climbs in the order it was probed ({:.2g} mm in all), not with the "
           "place: the same places touched by hand differ by {} um. What probes adds "
           "something each time (a lift that is not counted, relative mode left); "
           "discard "
           "the map, the surface is flat",
           rise_mm,
           TwoDigits(UmFromMm(high - low))),
       facts);
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "plane" || fact.id == "form" || fact.id == "twist";
  });
}

}  // namespace

void FactsOfSetting(const std::vector<const Row*>& rows, Facts* facts) {
  AddZeroOffset(rows, facts);
  AddTools(rows, facts);
  AddSides(rows, facts);
  AddDoubledCorrection(rows, facts);
  AddAddedConstant(rows, facts);
  AddContradictingSizes(rows, facts);
  AddDriftBySetting(rows, facts);
  AddClimbingMap(rows, facts);
}

}  // namespace caltwin
