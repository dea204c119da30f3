#include "calibration/facts/outliers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/repeats.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

double MedianOf(const Rows& rows) {
  std::vector<double> values_mm;
  for (const Row* row : rows) values_mm.push_back(row->value_mm);
  std::ranges::sort(values_mm);
  const std::size_t half = values_mm.size() / 2;
  return values_mm.size() % 2 == 1 ? values_mm[half]
                                   : (values_mm[half - 1] + values_mm[half]) / 2;
}

// How far a reading may be from the middle of its place, by campaign: ten times the
// usual distance of all its places with three readings or more; none where there are
// too few.
std::map<std::string, double> FarLimits_mm(const std::vector<Rows>& cells,
                                           double resolution_mm) {
  constexpr std::size_t kFewest = 3, kFewestInAll = 4;
  constexpr double kFar = 10;
  std::map<std::string, std::vector<double>> sizes_mm;
  for (const Rows& cell : cells) {
    if (cell.size() < kFewest) continue;
    const double middle_mm = MedianOf(cell);
    for (const Row* row : cell) {
      sizes_mm[cell.front()->campaign].push_back(std::abs(row->value_mm - middle_mm));
    }
  }
  std::map<std::string, double> limits_mm;
  for (const auto& [campaign, sizes] : sizes_mm) {
    if (sizes.size() < kFewestInAll) continue;
    limits_mm[campaign] =
        kFar * std::max(kSigmaOfMedian * Median(sizes), std::max(resolution_mm, 1e-6));
  }
  return limits_mm;
}

// What all places do at one moment: up to it, or from it on, they are far from their
// other readings.
struct CommonJump {
  std::size_t num_places = 0;
  std::int64_t last = std::numeric_limits<std::int64_t>::min();   ///< Row before it.
  std::int64_t first = std::numeric_limits<std::int64_t>::max();  ///< Row after it.
  double sum_mm = 0;  ///< Of the places' changes.
  bool is_one_way = true;
};

// Of the places that do nothing else.
CommonJump JumpOf(const std::vector<Rows>& cells,
                  const std::set<std::int64_t>& far,
                  bool is_before) {
  const auto is_far = [&](const Row* row) {
    return far.contains(row->row);
  };
  CommonJump jump;
  for (const Rows& cell : cells) {
    Rows ordered = cell;
    std::ranges::sort(ordered, {}, &Row::row);
    const auto change = is_before ? std::ranges::find_if_not(ordered, is_far)
                                  : std::ranges::find_if(ordered, is_far);
    const bool is_clean = is_before ? std::none_of(change, ordered.end(), is_far)
                                    : std::all_of(change, ordered.end(), is_far);
    if (change == ordered.begin() || change == ordered.end() || !is_clean) continue;
    ++jump.num_places;
    const double change_mm =
        MedianOf(Rows(change, ordered.end())) - MedianOf(Rows(ordered.begin(), change));
    jump.is_one_way &= change_mm * jump.sum_mm >= 0;
    jump.sum_mm += change_mm;
    jump.last = std::max(jump.last, (*std::prev(change))->row);
    jump.first = std::min(jump.first, (*change)->row);
  }
  return jump;
}

// Whether a third at least of the places that were read on both sides of it take part
// (a screw that slips moves those near it).
bool IsOfMany(const CommonJump& jump, const std::vector<Rows>& cells) {
  std::size_t num_both = 0;
  for (const Rows& cell : cells) {
    const bool has_before = std::ranges::any_of(
        cell, [&](const Row* row) { return row->row <= jump.last; });
    const bool has_after = std::ranges::any_of(
        cell, [&](const Row* row) { return row->row >= jump.first; });
    num_both += has_before && has_after ? 1 : 0;
  }
  return 3 * jump.num_places >= num_both;
}

void TellJump(const CommonJump& jump, Facts* facts) {
  const double change_um = UmFromMm(jump.sum_mm / static_cast<double>(jump.num_places));
  facts->all.push_back(
      {.id = "jump",
       .word = "everywhere",
       .figures = {{"change_um", change_um}},
       .rows = {jump.last, jump.first},
       .sentence = fmt::format(
           "After row {}, {} places read {} um {} than before, all at once, and stay "
           "there: something moved or was set anew between rows {} and {} (lost steps, "
           "a "
           "loose probe, a new zero), and none of them is a bad reading",
           jump.last,
           jump.num_places,
           TwoDigits(std::abs(change_um)),
           change_um > 0 ? "higher" : "lower",
           jump.last,
           jump.first),
       .is_answer = true});
}

// Takes out of `far` what is no bad reading, and tells why.
void KeepJumps(const std::vector<Rows>& cells,
               std::set<std::int64_t>* far,
               Facts* facts) {
  constexpr std::size_t kFewestPlaces = 3;
  for (const bool is_before : {true, false}) {
    const CommonJump jump = JumpOf(cells, *far, is_before);
    if (jump.num_places < kFewestPlaces || jump.last > jump.first || !jump.is_one_way ||
        !IsOfMany(jump, cells)) {
      continue;
    }
    // A place may have a bad reading besides.
    for (const Rows& cell : cells) {
      Rows of_jump;
      for (const Row* row : cell) {
        const bool is_of_it =
            is_before ? row->row <= jump.last : row->row >= jump.first;
        if (is_of_it) of_jump.push_back(row);
      }
      const bool are_far = std::ranges::all_of(
          of_jump, [&](const Row* row) { return far->contains(row->row); });
      if (!are_far) continue;
      for (const Row* row : of_jump) far->erase(row->row);
    }
    TellJump(jump, facts);
  }
}

// Readings of one place that come nearer to the rest one by one, the far ones first:
// it settles (cold, or just heated), and the first readings are as good as the last.
// `ordered`: as measured, or its mirror where the far ones are the last.
bool Settles(const Rows& ordered, double middle_mm, const std::set<std::int64_t>& far) {
  constexpr std::size_t kFewest = 6;
  std::size_t num_far = 0, num_nearer = 1;
  for (const Row* row : ordered) num_far += far.contains(row->row) ? 1 : 0;
  while (num_nearer < ordered.size()) {
    const double before_mm = ordered[num_nearer - 1]->value_mm - middle_mm;
    const double here_mm = ordered[num_nearer]->value_mm - middle_mm;
    if (std::abs(here_mm) >= std::abs(before_mm) || here_mm * before_mm < 0) break;
    ++num_nearer;
  }
  const bool are_first =
      std::ranges::all_of(ordered.begin(),
                          ordered.begin() + static_cast<std::ptrdiff_t>(num_far),
                          [&](const Row* row) { return far.contains(row->row); });
  return num_far > 0 && are_first && num_nearer >= std::max(kFewest, num_far + 3);
}

// How many readings of one place, the first of `ordered` (as measured, or its mirror),
// are far from the rest and alike among themselves: something moved. So many bad
// readings in a row do not agree. 0: fewer than four.
std::size_t NumOfLevel(const Rows& ordered,
                       double limit_mm,
                       const std::set<std::int64_t>& far) {
  constexpr std::size_t kFewest = 4;
  std::size_t num_far = 0;
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;
  for (const Row* row : ordered) {
    if (!far.contains(row->row)) break;
    least_mm = std::min(least_mm, row->value_mm);
    most_mm = std::max(most_mm, row->value_mm);
    ++num_far;
  }
  const bool is_jump = num_far >= kFewest && most_mm - least_mm < limit_mm;
  return is_jump ? num_far : 0;
}

// Takes out of `far` the readings of places that settle or jump.
void KeepSettlingAndJumps(const std::vector<Rows>& cells,
                          const std::map<std::string, double>& limits_mm,
                          std::set<std::int64_t>* far) {
  for (const Rows& cell : cells) {
    const auto limit = limits_mm.find(cell.front()->campaign);
    if (limit == limits_mm.end()) continue;
    Rows ordered = cell;
    std::ranges::sort(ordered, {}, &Row::row);
    const double middle_mm = MedianOf(cell);
    for (int way = 0; way < 2; ++way, std::ranges::reverse(ordered)) {
      const std::size_t num = Settles(ordered, middle_mm, *far)
                                  ? ordered.size()
                                  : NumOfLevel(ordered, limit->second, *far);
      for (std::size_t i = 0; i < num; ++i) far->erase(ordered[i]->row);
    }
  }
}

}  // namespace

void LeaveOutFar(const std::vector<Rows>& cells,
                 std::vector<Rows>* batches,
                 double resolution_mm,
                 std::set<std::int64_t>* outliers,
                 Facts* facts) {
  constexpr std::size_t kFewest = 3;
  const auto limits_mm = FarLimits_mm(cells, resolution_mm);
  std::set<std::int64_t> far;
  std::map<std::int64_t, double> far_mm, limit_of_mm;
  for (const Rows& cell : cells) {
    const auto limit = limits_mm.find(cell.front()->campaign);
    if (cell.size() < kFewest || limit == limits_mm.end()) continue;
    const double limit_mm = limit->second;
    const double middle_mm = MedianOf(cell);
    Rows here;
    for (const Row* row : cell) {
      if (std::abs(row->value_mm - middle_mm) > limit_mm) here.push_back(row);
    }
    if (3 * here.size() > cell.size()) continue;
    for (const Row* row : here) {
      far.insert(row->row);
      far_mm[row->row] = std::abs(row->value_mm - middle_mm);
      limit_of_mm[row->row] = limit_mm;
    }
  }
  KeepJumps(cells, &far, facts);
  KeepSettlingAndJumps(cells, limits_mm, &far);
  for (Rows& batch : *batches) {
    // All of a homing session are far together, beside each other: no bad reading.
    Rows own;
    for (const Row* row : batch) {
      if (far.contains(row->row)) own.push_back(row);
    }
    if (own.empty()) continue;
    const bool is_session = batch.front()->home != batches->front().front()->home ||
                            batches->size() > cells.size();
    const auto [low, high] = std::ranges::minmax(own, {}, &Row::value_mm);
    const bool are_together =
        high->value_mm - low->value_mm < limit_of_mm.at(own.front()->row);
    if (is_session && own.size() == batch.size() && own.size() > 1) {
      if (are_together) continue;
      // They contradict each other: the one that is further from the place's middle.
      const auto further = std::ranges::max_element(
          own, {}, [&](const Row* row) { return far_mm.at(row->row); });
      own = {*further};
    }
    // Of a batch that stands at a level of its own only what is far from that.
    constexpr std::size_t kOfLevel = 3;
    if (is_session && batch.size() >= kOfLevel) {
      const double level_mm = MedianOf(batch);
      std::erase_if(own, [&](const Row* row) {
        return std::abs(row->value_mm - level_mm) < limit_of_mm.at(row->row);
      });
    }
    for (const Row* row : own) outliers->insert(row->row);
    std::erase_if(batch, [&](const Row* row) {
      return std::ranges::find(own, row) != own.end();
    });
  }
  std::erase_if(*batches, [](const Rows& batch) { return batch.empty(); });
  KeepJumps(cells, outliers, facts);
}

void AddOutliers(const std::set<std::int64_t>& outliers,
                 const Rows& rows,
                 Facts* facts) {
  if (outliers.empty()) return;
  Fact fact{.id = "outliers",
            .figures = {{"count", static_cast<double>(outliers.size())}},
            .rows = {outliers.begin(), outliers.end()},
            .is_answer = true};
  double worst_mm = 0;
  for (const auto& [key, cell] : CellsOf(rows, kAnyHome | kAnyCampaign)) {
    Rows good;
    for (const Row* row : cell) {
      if (!outliers.contains(row->row)) good.push_back(row);
    }
    if (good.empty() || good.size() == cell.size()) continue;
    for (const Row* row : cell) {
      if (!outliers.contains(row->row)) continue;
      worst_mm = std::max(worst_mm, std::abs(row->value_mm - MedianOf(good)));
    }
  }
  fact.sentence =
      outliers.size() == 1
          ? fmt::format(
                "Row {} is {} um from the others of its place: a bad reading, "
                "left out",
                *outliers.begin(),
                TwoDigits(UmFromMm(worst_mm)))
          : fmt::format(
                "Rows {} are up to {} um from the others of their places: bad "
                "readings, left out",
                fmt::join(fact.rows, ", "),
                TwoDigits(UmFromMm(worst_mm)));
  facts->all.push_back(std::move(fact));
}

void AddContradiction(const std::vector<Rows>& batches,
                      const DataHeader& header,
                      Facts* facts) {
  constexpr double kFar = 5;
  const Row *one = nullptr, *other = nullptr;
  double worst = kFar;
  for (const Rows& batch : batches) {
    const auto [low, high] = std::ranges::minmax_element(batch, {}, &Row::value_mm);
    const double sd_mm =
        std::hypot(StatedSigma_mm(**low, header), StatedSigma_mm(**high, header));
    if (!Known(sd_mm) || sd_mm <= 0) continue;
    const double sigmas = ((*high)->value_mm - (*low)->value_mm) / sd_mm;
    if (sigmas <= worst) continue;
    worst = sigmas;
    one = *low;
    other = *high;
  }
  if (one == nullptr) return;
  facts->all.push_back(
      {.id = "contradiction",
       .figures = {{"sigmas", worst},
                   {"apart_um", UmFromMm(other->value_mm - one->value_mm)}},
       .rows = {std::min(one->row, other->row), std::max(one->row, other->row)},
       .sigmas = worst,
       .sentence = fmt::format(
           "Rows {} and {} measure the same and are {} um apart, {:.0f} times what "
           "their "
           "stated uncertainties allow: one of them, or the stated figure, is wrong",
           std::min(one->row, other->row),
           std::max(one->row, other->row),
           TwoDigits(UmFromMm(other->value_mm - one->value_mm)),
           worst),
       .is_answer = true});
}

}  // namespace caltwin
