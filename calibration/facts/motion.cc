#include "calibration/facts/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/motion_line.h"
#include "calibration/facts/scale.h"
#include "sim/base/dense.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

constexpr double kSure = 4;

Rows Without(const Rows& rows, const std::set<std::int64_t>& out) {
  Rows kept;
  for (const Row* row : rows) {
    if (!out.contains(row->row)) kept.push_back(row);
  }
  return kept;
}

// The drive moves and what it drives stands still, until the play is used up.
bool AddDeadZone(const Rows& rows, std::size_t axis, Facts* facts) {
  constexpr std::size_t kFewest = 2, kFewestBeyond = 4;
  constexpr double kStill = 0.15, kAlike = 0.1, kLeast_mm = 0.005;
  std::vector<double> lost_mm;
  double most_mm = 0;
  for (const Row* row : rows) most_mm = std::max(most_mm, row->cmd_mm[axis]);
  for (const Row* row : rows) {
    if (row->cmd_mm[axis] > most_mm / 2) lost_mm.push_back(-row->value_mm);
  }
  if (lost_mm.size() < 3) return false;
  const double gap_mm = Median(lost_mm);
  std::size_t num_still = 0, num_beyond = 0;
  double squares_mm2 = 0;
  for (const Row* row : rows) {
    const double told_mm = row->cmd_mm[axis], moved_mm = told_mm + row->value_mm;
    if (told_mm < 0.9 * gap_mm) {
      if (std::abs(moved_mm) > kStill * gap_mm) return false;
      ++num_still;
    } else if (told_mm > 1.1 * gap_mm) {
      if (std::abs(moved_mm - (told_mm - gap_mm)) > kAlike * gap_mm) return false;
      squares_mm2 += std::pow(moved_mm - (told_mm - gap_mm), 2);
      ++num_beyond;
    }
  }
  if (num_still < kFewest || num_beyond < kFewestBeyond || gap_mm < kLeast_mm)
    return false;
  const auto num = static_cast<double>(num_beyond);
  const double sd_mm = std::sqrt(squares_mm2 / (num - 1) / num);
  facts->all.push_back(
      {.id = "reversal",
       .axis = kAxisNames[axis],
       .word = "dead_zone",
       .figures = {{"gap_um", UmFromMm(gap_mm), UmFromMm(sd_mm)}},
       .sigmas = gap_mm / std::max(sd_mm, 1e-12),
       .sentence = fmt::format(
           "Nothing moves until the drive has gone {}, and beyond that everything lags "
           "by "
           "as much: play between the two places that were measured (a coupling, a "
           "nut, a "
           "grub screw). What drives follows its steps; steps/mm are not in question",
           WithSd(gap_mm, sd_mm, "mm")),
       .is_answer = true});
  return true;
}

// The coarsest step that all readings are whole multiples of, of a rule or a gauge that
// is read to it [mm]; 0 where they are finer than a tenth.
double CoarseStep_mm(const Rows& rows, std::size_t axis) {
  for (const double step_mm : {1.0, 0.5, 0.1}) {
    const bool is_it = std::ranges::all_of(rows, [&](const Row* row) {
      const double steps = (row->cmd_mm[axis] + row->value_mm) / step_mm;
      return std::abs(steps - std::round(steps)) < 1e-6;
    });
    if (is_it) return step_mm;
  }
  return 0;
}

// No reading is off by more than one step of the gauge: it does not show a scale.
bool IsWithinStep(const Rows& rows, std::size_t axis, Facts* facts) {
  constexpr std::size_t kMost = 6;
  const double step_mm = CoarseStep_mm(rows, axis);
  const bool is_within = step_mm >= 0.5 && rows.size() <= kMost &&
                         std::ranges::all_of(rows, [&](const Row* row) {
                           return row->flag == kMoveFlag &&
                                  std::abs(row->value_mm) < 1.001 * step_mm &&
                                  row->cmd_mm[axis] > 5 * step_mm;
                         });
  if (!is_within) return false;
  facts->not_determined.push_back(fmt::format("scale.{}", kAxisNames[axis]));
  facts->cannot.push_back(fmt::format(
      "steps/mm of {}: no reading is off by more than one division of the gauge ({:g} "
      "mm), and that is what it leaves open",
      "XYZ"[axis],
      step_mm));
  facts->next.push_back({"calliper",
                         "measure a move as long as the axis allows with a calliper or "
                         "a scale, from a mark "
                         "to a mark: a rule read to its divisions does not tell a few "
                         "parts in a thousand"});
  return true;
}

void AddReversal(const Line& line, double noise_mm, std::size_t axis, Facts* facts) {
  if (!line.has_gap) return;
  const double sd_mm = noise_mm * line.gap_unit_sd;
  constexpr double kLeastUnknown_mm = 0.01;
  const bool is_there = Known(sd_mm) ? std::abs(line.gap_mm) > kSure * sd_mm
                                     : std::abs(line.gap_mm) > kLeastUnknown_mm;
  if (!is_there) return;
  Fact fact{.id = "reversal",
            .axis = kAxisNames[axis],
            .figures = {{"gap_um", UmFromMm(line.gap_mm), UmFromMm(sd_mm)}},
            .sigmas = std::abs(line.gap_mm) / std::max(sd_mm, 1e-12),
            .is_answer = true};
  if (!Known(sd_mm)) fact.sigmas = kUnknown;
  fact.sentence = fmt::format(
      "{} {} {} at its reversals{}",
      "XYZ"[axis],
      line.gap_mm > 0 ? "loses" : "leads by",
      WithSd(std::abs(line.gap_mm), sd_mm, "mm"),
      Known(sd_mm) ? ""
                   : ". Its uncertainty is not known: no reading was repeated, and no "
                     "uncertainty is stated");
  facts->all.push_back(std::move(fact));
}

// The same at slow and fast: nothing that takes a time.
void AddWhetherByFeed(const Rows& rows, std::size_t axis, Facts* facts) {
  constexpr double kFaster = 3, kAlike = 0.2;
  constexpr std::size_t kFewest = 3;
  if (facts->all.empty() || facts->all.back().id != "reversal") return;
  struct Sums {
    double plus_mm = 0, minus_mm = 0, num_plus = 0, num_minus = 0;
  };
  std::map<double, Sums> by_feed;
  for (const Row* row : rows) {
    if (!Known(row->feed_mm_s) || !Known(row->dir[axis]) || row->dir[axis] == 0) return;
    Sums& sums = by_feed[std::abs(row->feed_mm_s)];
    (row->dir[axis] > 0 ? sums.plus_mm : sums.minus_mm) += row->value_mm;
    (row->dir[axis] > 0 ? sums.num_plus : sums.num_minus) += 1;
  }
  if (by_feed.size() < kFewest ||
      by_feed.rbegin()->first < kFaster * by_feed.begin()->first) {
    return;
  }
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;
  for (const auto& [feed_mm_s, sums] : by_feed) {
    if (sums.num_plus == 0 || sums.num_minus == 0) return;
    const double gap_mm = sums.minus_mm / sums.num_minus - sums.plus_mm / sums.num_plus;
    least_mm = std::min(least_mm, gap_mm);
    most_mm = std::max(most_mm, gap_mm);
  }
  const double gap_mm = std::abs(MmFromUm(facts->all.back().figures[0].value));
  if (most_mm - least_mm > kAlike * gap_mm) return;
  facts->all.back().sentence += fmt::format(
      ", alike from {:.4g} to {:.4g} mm/min: lost motion, or an offset that a program "
      "adds, and no delay, which would grow with the feed",
      by_feed.begin()->first * SFromMin(1.0),
      by_feed.rbegin()->first * SFromMin(1.0));
}

// What part of the rows facts from `first` on are of, where others say the same of the
// same axis.
void NamePart(const Row& row, std::size_t first, Facts* facts) {
  std::string part = row.campaign;  // A heading, made a name by its reader.
  std::ranges::replace(part, '_', ' ');
  for (std::size_t k = first; k < facts->all.size(); ++k) {
    facts->all[k].sentence =
        fmt::format("By the rows of '{}': {}", part, facts->all[k].sentence);
  }
}

// Steps/mm that were in force; kUnknown: nobody says.
double StepsSet(const Row& row, const DataHeader& header, std::size_t axis) {
  const auto settings = header.settings.find(row.settings);
  if (settings == header.settings.end()) return kUnknown;
  const auto steps = settings->second.steps_per_mm.find(kAxisNames[axis]);
  return steps == settings->second.steps_per_mm.end() ? kUnknown : steps->second;
}

// Rows of one gauge along one axis.
void AddAlong(const Rows& rows,
              const Repeats& repeats,
              const DataHeader& header,
              Facts* facts) {
  using Key = std::pair<std::string, int>;
  std::map<Key, Rows> series;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    if (row->kind != RowKind::kPosition || axis < 0) continue;
    // What a side of a square should measure is the mean of its sides here.
    if (row->flag == kLengthFlag) continue;
    if (!Known(row->cmd_mm[static_cast<std::size_t>(axis)])) continue;
    series[{row->campaign + "|" + row->setup + "|" + row->settings, axis}].push_back(
        row);
  }
  std::map<int, std::set<std::string>> campaigns;
  for (const auto& [key, all] : series) {
    campaigns[key.second].insert(all.front()->campaign);
  }
  for (const auto& [key, all] : series) {
    const auto axis = static_cast<std::size_t>(key.second);
    const std::size_t first = facts->all.size();
    if (AddDeadZone(all, axis, facts) || IsWithinStep(all, axis, facts)) continue;
    const Line line = FitBeyondGap(Without(all, repeats.outliers), axis);
    if (line.dof < 0) continue;
    double noise_mm = NoiseOf_mm(line, repeats.NoiseOf(*all.front()));
    // Readings that lie on the line as well as they were read off.
    constexpr double kEnough = 3;
    const double step_mm = FinestStep_mm(all);
    if (line.dof >= kEnough && step_mm > 0 && !Known(noise_mm)) {
      noise_mm =
          std::max(std::sqrt(line.left_mm2 / line.dof), step_mm / std::sqrt(12.0));
    }
    // How far it was sent before is no place.
    const bool is_lost_motion = all.front()->flag == kLostMotionFlag;
    if (!is_lost_motion && line.has_slope) {
      FactsOfLine(line, noise_mm, axis, StepsSet(*all.front(), header, axis), facts);
    }
    AddReversal(line, noise_mm, axis, facts);
    AddWhetherByFeed(all, axis, facts);
    if (campaigns[key.second].size() > 1) NamePart(*all.front(), first, facts);
  }
}

/// Difference of readings by the sense of an axis across which they are taken.
struct SenseContrast {
  double sum_mm = 0, weight = 0, noise_mm = 0;
  int places = 0;
};

// Readings along n, at the same place, that differ by the sense in which an axis across
// n arrived.
void AddAcross(const Rows& rows, const Repeats& repeats, Facts* facts) {
  if (!Known(repeats.noise.sd_mm)) return;
  constexpr int kFewestPlaces = 2;
  std::map<std::pair<int, int>, SenseContrast> contrasts;
  for (const auto& [key, cell] : CellsOf(rows, kAnySense | kAnyHome)) {
    const int along = AxisAlong(*cell.front());
    if (along < 0) continue;
    for (int across = 0; across < 3; ++across) {
      if (across == along) continue;
      double sum_mm[2] = {0, 0}, num[2] = {0, 0};
      for (const Row* row : cell) {
        const double sense = row->dir[static_cast<std::size_t>(across)];
        if (!Known(sense) || sense == 0) continue;
        sum_mm[sense > 0] += row->value_mm;
        num[sense > 0] += 1;
      }
      if (num[0] == 0 || num[1] == 0) continue;
      const double weight = 1 / (1 / num[0] + 1 / num[1]);
      SenseContrast& contrast = contrasts[{along, across}];
      contrast.sum_mm += weight * (sum_mm[1] / num[1] - sum_mm[0] / num[0]);
      contrast.weight += weight;
      const double noise_mm = repeats.NoiseOf(*cell.front()).sd_mm;
      if (Known(noise_mm)) contrast.noise_mm = std::max(contrast.noise_mm, noise_mm);
      ++contrast.places;
    }
  }
  for (const auto& [axes, contrast] : contrasts) {
    const double gap_mm = contrast.sum_mm / contrast.weight;
    const double sd_mm = contrast.noise_mm / std::sqrt(contrast.weight);
    const bool is_sure =
        std::abs(gap_mm) > kSure * sd_mm && contrast.places >= kFewestPlaces;
    if (!is_sure) continue;
    const auto along = static_cast<std::size_t>(axes.first);
    const auto across = static_cast<std::size_t>(axes.second);
    facts->all.push_back(
        {.id = "cross_reversal",
         .axis = kAxisNames[across],
         .word = kAxisNames[along],
         .figures = {{"gap_um", UmFromMm(gap_mm), UmFromMm(sd_mm)}},
         .sigmas = std::abs(gap_mm) / sd_mm,
         .sentence = fmt::format("At the same place {} reads {} more when {} arrived "
                                 "in its + sense than in "
                                 "its - sense ({} places): the {} carriage tilts or "
                                 "shifts with the sense in "
                                 "which it is pulled (play of its wheels, bearings or "
                                 "belt anchor), and shows "
                                 "it in {}. It is no backlash of {} and no noise",
                                 "XYZ"[along],
                                 WithSd(gap_mm, sd_mm, "mm"),
                                 "XYZ"[across],
                                 contrast.places,
                                 "XYZ"[across],
                                 "XYZ"[along],
                                 "XYZ"[along]),
         .is_answer = true});
  }
}

// Steps/mm were changed and the travel was not: what is set is not in force.
void AddIdleSettings(const Rows& rows, const DataHeader& header, Facts* facts) {
  constexpr double kLeastChange = 1.05, kAlike = 0.02;
  std::map<int, std::map<double, std::vector<double>>> factors;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    const auto settings = header.settings.find(row->settings);
    if (row->flag != kMoveFlag || axis < 0 || settings == header.settings.end())
      continue;
    const auto steps =
        settings->second.steps_per_mm.find(kAxisNames[static_cast<std::size_t>(axis)]);
    const double told_mm = row->cmd_mm[static_cast<std::size_t>(axis)];
    if (steps == settings->second.steps_per_mm.end() || told_mm == 0) continue;
    factors[axis][steps->second].push_back(1 + row->value_mm / told_mm);
  }
  for (const auto& [axis, by_steps] : factors) {
    if (by_steps.size() < 2) continue;
    const double range = by_steps.rbegin()->first / by_steps.begin()->first;
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (const auto& [steps, all] : by_steps) {
      least = std::min(least, Median(all));
      most = std::max(most, Median(all));
    }
    if (range < kLeastChange || most / least - 1 > kAlike) continue;
    const std::string sentence = fmt::format(
        "{} moves {:.4g} times what is commanded whatever steps/mm are set ({:g} to "
        "{:g}): "
        "the setting is not in force. Find out which file or memory the board reads "
        "(ask it: "
        "M503, M92, $$) before anything else; nothing of the mechanics is shown to be "
        "wrong",
        "XYZ"[axis],
        (least + most) / 2,
        by_steps.begin()->first,
        by_steps.rbegin()->first);
    facts->all.push_back({.id = "settings",
                          .axis = kAxisNames[static_cast<std::size_t>(axis)],
                          .word = "steps_per_mm",
                          .sentence = sentence,
                          .is_answer = true});
    facts->not_the_machine = {"settings", sentence};
  }
}

}  // namespace

void FactsOfMotion(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   const DataHeader& header,
                   Facts* facts) {
  AddIdleSettings(rows, header, facts);
  const Rows kept = Without(rows, repeats.outliers);
  AddAlong(kept, repeats, header, facts);
  AddAcross(kept, repeats, facts);
  FactsOfLatency(kept, repeats, facts);
}

}  // namespace caltwin
