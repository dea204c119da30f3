#include "calibration/facts/repeats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/estimate/f_test.h"
#include "calibration/facts/cells.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

using Rows = std::vector<const Row*>;

constexpr double kLeastLevel_mm = 0.02;  // Smaller jumps are anybody's.
constexpr double kApart = 8;             // Jumps between levels over scatter within.

double MeanOf(const Rows& rows) {
  double sum_mm = 0;
  for (const Row* row : rows) sum_mm += row->value_mm;
  return sum_mm / static_cast<double>(rows.size());
}

double SquaresAbout(const Rows& rows, double mean_mm) {
  double sum_mm2 = 0;
  for (const Row* row : rows) sum_mm2 += std::pow(row->value_mm - mean_mm, 2);
  return sum_mm2;
}

std::vector<double> StepsOf(const Rows& rows) {
  std::vector<double> steps_mm;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    steps_mm.push_back(rows[i]->value_mm - rows[i - 1]->value_mm);
  }
  return steps_mm;
}

std::string PlaceInWords(const Row& row) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < 3; ++k) {
    if (Known(row.cmd_mm[k])) {
      parts.push_back(fmt::format("{} {:g}", "XYZ"[k], row.cmd_mm[k]));
    }
  }
  if (row.kind == RowKind::kTouch && parts.size() > 2) parts.pop_back();
  return parts.empty() ? "one place" : fmt::format("{}", fmt::join(parts, " "));
}

// The size from which a step between readings is a jump, where two kinds of steps are
// plain to see: at least two in five are eight times smaller than all the others.
std::optional<double> JumpSize_mm(const Rows& rows, double resolution_mm) {
  constexpr std::size_t kFewest = 5;
  if (rows.size() < kFewest) return std::nullopt;
  std::vector<double> sizes_mm = StepsOf(rows);
  for (double& size_mm : sizes_mm) size_mm = std::abs(size_mm);
  std::ranges::sort(sizes_mm);
  const auto least = std::max<std::size_t>(2, (2 * sizes_mm.size() + 4) / 5);
  double best = kApart;
  std::optional<double> jump_mm;
  for (std::size_t k = least; k < sizes_mm.size(); ++k) {
    const double small_mm = std::max(sizes_mm[k - 1], resolution_mm);
    const double ratio = sizes_mm[k] / std::max(small_mm, 1e-9);
    if (ratio < best || sizes_mm[k] < kLeastLevel_mm) continue;
    best = ratio;
    jump_mm = std::sqrt(small_mm * sizes_mm[k]);
  }
  return jump_mm;
}

// Two groups of values with a wide gap between them, taken in turn; empty where there
// are none.
std::vector<Rows> TwoGroups(const Rows& rows, double resolution_mm) {
  constexpr std::size_t kFewest = 3;
  Rows sorted = rows;
  std::ranges::stable_sort(sorted, {}, &Row::value_mm);
  std::size_t at = 0;
  double widest_mm = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap_mm = sorted[i]->value_mm - sorted[i - 1]->value_mm;
    if (gap_mm > widest_mm) {
      widest_mm = gap_mm;
      at = i;
    }
  }
  if (at < kFewest || sorted.size() - at < kFewest) return {};
  const double within_mm =
      std::max({sorted[at - 1]->value_mm - sorted.front()->value_mm,
                sorted.back()->value_mm - sorted[at]->value_mm,
                resolution_mm});
  if (widest_mm < kLeastLevel_mm || widest_mm < kApart * within_mm) return {};
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(at);
  return {Rows(sorted.begin(), middle), Rows(middle, sorted.end())};
}

std::vector<Rows> SplitAtJumps(const Rows& rows, double jump_mm) {
  std::vector<Rows> levels = {{rows.front()}};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (std::abs(rows[i]->value_mm - rows[i - 1]->value_mm) > jump_mm) {
      levels.emplace_back();
    }
    levels.back().push_back(rows[i]);
  }
  return levels;
}

// A reading that leaves its level and comes back to it, or stands alone at an end, is
// an outlier. What is left, level by level.
std::vector<Rows> WithoutExcursions(std::vector<Rows> levels,
                                    double jump_mm,
                                    std::set<std::int64_t>* outliers) {
  const auto is_far = [&](const Rows& one, const Rows& other) {
    return std::abs(MeanOf(one) - MeanOf(other)) > jump_mm;
  };
  constexpr std::size_t kFewest = 3;
  std::size_t num = 0, alone = 0;
  for (const Rows& level : levels) {
    num += level.size();
    alone += level.size() == 1 ? 1 : 0;
  }
  // Two places taken in turn are no bad readings.
  if (4 * alone > num) return levels;
  for (std::size_t k = 0; k < levels.size();) {
    const bool is_alone = levels[k].size() == 1 && levels.size() > 1;
    const bool has_both = k > 0 && k + 1 < levels.size();
    const bool comes_back = is_alone && has_both &&
                            !is_far(levels[k - 1], levels[k + 1]) &&
                            levels[k - 1].size() + levels[k + 1].size() >= kFewest;
    const bool is_end = is_alone && !has_both && levels.size() == 2 &&
                        levels[k == 0 ? 1 : 0].size() > kFewest;
    if (!comes_back && !is_end) {
      ++k;
      continue;
    }
    outliers->insert(levels[k].front()->row);
    levels.erase(levels.begin() + static_cast<std::ptrdiff_t>(k));
    if (comes_back) {
      Rows& before = levels[k - 1];
      before.insert(before.end(), levels[k].begin(), levels[k].end());
      levels.erase(levels.begin() + static_cast<std::ptrdiff_t>(k));
      k = 0;
    }
  }
  return levels;
}

std::vector<Rows> ByHome(const Rows& rows) {
  std::vector<std::string> homes;
  std::map<std::string, Rows> by_home;
  for (const Row* row : rows) {
    if (!by_home.contains(row->home)) homes.push_back(row->home);
    by_home[row->home].push_back(row);
  }
  std::vector<Rows> batches;
  for (const std::string& home : homes) batches.push_back(by_home[home]);
  return batches;
}

struct Within {
  double squares_mm2 = 0;
  double dof = 0;
  double sd_mm() const { return dof > 0 ? std::sqrt(squares_mm2 / dof) : kUnknown; }
};

Within WithinOf(const std::vector<Rows>& batches) {
  Within within;
  for (const Rows& batch : batches) {
    within.squares_mm2 += SquaresAbout(batch, MeanOf(batch));
    within.dof += static_cast<double>(batch.size()) - 1;
  }
  return within;
}

// Batches of one place: how far their means scatter beyond what each shows by itself.
void AddHomings(const std::vector<Rows>& batches,
                bool are_homings,
                double resolution_mm,
                Facts* facts) {
  constexpr double kMostChance = 1e-3;
  Within within = WithinOf(batches);
  const double rounding_mm = resolution_mm / std::sqrt(12.0);
  within.squares_mm2 =
      std::max(within.squares_mm2, within.dof * rounding_mm * rounding_mm);
  Rows all;
  std::vector<double> means_mm;
  for (const Rows& batch : batches) {
    all.insert(all.end(), batch.begin(), batch.end());
    means_mm.push_back(MeanOf(batch));
  }
  const double between_dof = static_cast<double>(batches.size()) - 1;
  const double mean_mm = MeanOf(all);
  double between_mm2 = 0;
  for (const Rows& batch : batches) {
    between_mm2 +=
        static_cast<double>(batch.size()) * std::pow(MeanOf(batch) - mean_mm, 2);
  }
  between_mm2 /= between_dof;
  if (within.dof == 0) return;
  const double within_mm2 = std::max(within.squares_mm2 / within.dof, 1e-14);
  const double f = between_mm2 / within_mm2;
  if (are_homings && FUpperTail(f, between_dof, within.dof) > kMostChance) return;
  // Each session counts once, where sessions are known.
  if (!are_homings && !all.front()->home.empty()) {
    means_mm.clear();
    for (const Row* row : all) means_mm.push_back(row->value_mm);
  }
  double center_mm = 0, squares_mm2 = 0;
  for (const double each : means_mm)
    center_mm += each / static_cast<double>(means_mm.size());
  for (const double each : means_mm) squares_mm2 += std::pow(each - center_mm, 2);
  const double sd_mm =
      std::sqrt(squares_mm2 / (static_cast<double>(means_mm.size()) - 1));
  const auto [low, high] = std::ranges::minmax(means_mm);
  Fact fact{.id = "homing_scatter",
            .figures = {{"sd_um",
                         UmFromMm(sd_mm),
                         UmFromMm(sd_mm) / std::sqrt(2 * between_dof)},
                        {"range_um", UmFromMm(high - low)},
                        {"within_um", UmFromMm(std::sqrt(within_mm2))}},
            .sigmas = std::sqrt(f),
            .is_answer = true};
  for (const Row* row : all) fact.rows.push_back(row->row);
  fact.sentence = fmt::format(
      "{} {} differ by up to {} um at {}, while readings {} agree to {} um: the "
      "instrument repeats, and what happens between them moves the zero{}",
      batches.size(),
      are_homings ? "homing sessions" : "groups of readings",
      TwoDigits(UmFromMm(high - low)),
      PlaceInWords(*all.front()),
      are_homings ? "of one session" : "within a group",
      TwoDigits(UmFromMm(std::sqrt(within_mm2))),
      are_homings
          ? ""
          : ". Homing is the usual one (the file does not say); then levelling, "
            "a probe put down and taken up, a loose mount");
  facts->all.push_back(std::move(fact));
}

void AddJump(const std::vector<Rows>& levels, Facts* facts) {
  const double change_mm = MeanOf(levels[1]) - MeanOf(levels[0]);
  const Within within = WithinOf(levels);
  const double sd_mm =
      within.sd_mm() * std::sqrt(1.0 / static_cast<double>(levels[0].size()) +
                                 1.0 / static_cast<double>(levels[1].size()));
  Fact fact{.id = "jump",
            .figures = {{"change_um", UmFromMm(change_mm), UmFromMm(sd_mm)},
                        {"row", static_cast<double>(levels[1].front()->row)}},
            .rows = {levels[1].front()->row},
            .sigmas = std::abs(change_mm) / std::max(sd_mm, 1e-9),
            .is_answer = true};
  fact.sentence = fmt::format(
      "From row {} on the readings at {} are {} um {}, and stay there: something "
      "slipped "
      "or was moved between the two readings (lost steps, a loose probe or part, a new "
      "zero)",
      levels[1].front()->row,
      PlaceInWords(*levels[0].front()),
      TwoDigits(std::abs(UmFromMm(change_mm))),
      change_mm > 0 ? "higher" : "lower");
  facts->all.push_back(std::move(fact));
}

// Kendall's tau against chance: normal, and exact where every step goes one way.
double TrendSum(const Rows& rows) {
  double s = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = i + 1; j < rows.size(); ++j) {
      const double step_mm = rows[j]->value_mm - rows[i]->value_mm;
      s += step_mm > 0 ? 1 : step_mm < 0 ? -1 : 0;
    }
  }
  return s;
}

double TrendVariance(const Rows& rows) {
  const auto n = static_cast<double>(rows.size());
  return n * (n - 1) * (2 * n + 5) / 18;
}

double TrendChance(const Rows& rows) {
  const double s = TrendSum(rows);
  const auto n = static_cast<double>(rows.size());
  if (std::abs(s) == n * (n - 1) / 2) return 2 / std::tgamma(n + 1);
  const double z = std::max(0.0, std::abs(s) - 1) / std::sqrt(TrendVariance(rows));
  return std::erfc(z / std::sqrt(2.0));
}

/// A series that drifts.
struct Drift {
  double change_mm = 0;  ///< Last less first, each smoothed over a fifth.
  double sd_mm = 0;      ///< Of the change.
  double noise_mm = 0;   ///< Of one reading about the drift.
};

// What a series does from its first readings to its last, drift or not.
Drift ChangeOf(const Rows& rows, double resolution_mm) {
  const std::vector<double> steps_mm = StepsOf(rows);
  const double mean_mm = std::accumulate(steps_mm.begin(), steps_mm.end(), 0.0) /
                         static_cast<double>(steps_mm.size());
  double squares_mm2 = 0;
  for (const double step_mm : steps_mm) squares_mm2 += std::pow(step_mm - mean_mm, 2);
  const double noise_mm =
      std::max(std::sqrt(squares_mm2 / static_cast<double>(steps_mm.size() - 1) / 2),
               resolution_mm / std::sqrt(12.0));
  const std::size_t num = std::max<std::size_t>(1, rows.size() / 10);
  const Rows first(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(num));
  const Rows last(rows.end() - static_cast<std::ptrdiff_t>(num), rows.end());
  Drift drift{.change_mm = MeanOf(last) - MeanOf(first),
              .sd_mm = noise_mm * std::sqrt(2 / static_cast<double>(num)),
              .noise_mm = noise_mm};
  return drift;
}

std::optional<Drift> DriftOf(const Rows& rows, double resolution_mm) {
  constexpr std::size_t kFewest = 6;
  constexpr double kMostChance = 3e-3, kLeastSigmas = 2;
  if (rows.size() < kFewest || TrendChance(rows) > kMostChance) return std::nullopt;
  const Drift drift = ChangeOf(rows, resolution_mm);
  if (std::abs(drift.change_mm) < kLeastSigmas * drift.sd_mm) return std::nullopt;
  return drift;
}

/// A temperature that went along with a drift.
struct Companion {
  std::string_view name{};
  double Row::*member = nullptr;
};
constexpr std::array kCompanions = {Companion{"frame", &Row::temp_frame_c},
                                    Companion{"bed", &Row::temp_bed_c},
                                    Companion{"chamber", &Row::temp_chamber_c},
                                    Companion{"nozzle", &Row::temp_nozzle_c},
                                    Companion{"screw", &Row::temp_screw_c},
                                    Companion{"room", &Row::temp_ambient_c}};

// What of the temperatures rose or fell by more than two kelvin from first to last.
std::string WarmedInWords(const Rows& rows) {
  constexpr double kLeast_k = 2;
  std::vector<std::string> parts;
  for (const Companion& one : kCompanions) {
    const double first_c = rows.front()->*one.member, last_c = rows.back()->*one.member;
    if (!Known(first_c) || !Known(last_c) || std::abs(last_c - first_c) < kLeast_k) {
      continue;
    }
    parts.push_back(fmt::format("the {} went from {:.4g} to {:.4g} degrees Celsius",
                                one.name,
                                first_c,
                                last_c));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

// Whether any temperature differs by more than five kelvin among rows.
bool IsWarmed(const Rows& rows) {
  constexpr double kApart_k = 5;
  return std::ranges::any_of(kCompanions, [&](const Companion& one) {
    double least_c = HUGE_VAL, most_c = -HUGE_VAL;
    for (const Row* row : rows) {
      const double at_c = row->*one.member;
      if (!Known(at_c)) continue;
      least_c = std::min(least_c, at_c);
      most_c = std::max(most_c, at_c);
    }
    return most_c - least_c > kApart_k;
  });
}

bool KnowsTemperature(const Rows& rows) {
  return std::ranges::any_of(kCompanions, [&](const Companion& one) {
    return Known(rows.front()->*one.member) && Known(rows.back()->*one.member);
  });
}

void AddDrift(const Rows& rows, const Drift& drift, Facts* facts) {
  const std::vector<double> steps_mm = StepsOf(rows);
  const auto along = std::ranges::count_if(
      steps_mm, [&](double step_mm) { return step_mm * drift.change_mm > 0; });
  Fact fact{
      .id = "drift",
      .figures = {{"change_um", UmFromMm(drift.change_mm), UmFromMm(drift.sd_mm)}},
      .sigmas = std::abs(drift.change_mm) / std::max(drift.sd_mm, 1e-9),
      .is_answer = true};
  std::string over = fmt::format("{} readings", rows.size());
  const double time_s = rows.back()->t_s - rows.front()->t_s;
  if (Known(time_s) && time_s > 0) {
    fact.figures.push_back({"time_s", time_s});
    over += time_s < 600 ? fmt::format(" ({:.0f} s)", time_s)
                         : fmt::format(" ({:.0f} min)", time_s / SFromMin(1.0));
  }
  const std::string warmed = WarmedInWords(rows);
  fact.sentence = fmt::format(
      "The readings at {} {} by {} um over {} ({} of {} steps go that way); about this "
      "drift they scatter by {} um. {}",
      PlaceInWords(*rows.front()),
      drift.change_mm > 0 ? "rise" : "fall",
      TwoDigits(std::abs(UmFromMm(drift.change_mm))),
      over,
      along,
      steps_mm.size(),
      TwoDigits(UmFromMm(drift.noise_mm)),
      !warmed.empty()          ? "Meanwhile " + warmed
      : KnowsTemperature(rows) ? "No temperature that was logged went along"
                               : "Something settles or warms (probe, frame, bed): no "
                                 "temperature was logged");
  for (const Row* row : rows) fact.rows.push_back(row->row);
  facts->all.push_back(std::move(fact));
}

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

// A reading far from the middle of its place, homing or not, is bad where it stands
// alone: no other of its batch is beside it, and of the place a third at most.
void LeaveOutFar(const std::vector<Rows>& cells,
                 std::vector<Rows>* batches,
                 double resolution_mm,
                 std::set<std::int64_t>* outliers) {
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
    for (const Row* row : own) outliers->insert(row->row);
    std::erase_if(batch, [&](const Row* row) {
      return std::ranges::find(own, row) != own.end();
    });
  }
  std::erase_if(*batches, [](const Rows& batch) { return batch.empty(); });
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

// Readings of one thing further apart than their stated uncertainties allow.
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

void AddRepeatability(const ReadingNoise& noise,
                      std::size_t num_places,
                      bool are_touches,
                      Facts* facts) {
  if (!Known(noise.sd_mm) || noise.is_stated) return;
  constexpr double kWild_mm = 0.3;
  const bool is_wild = are_touches && noise.sd_mm > kWild_mm;
  facts->all.push_back(
      {.id = "repeatability",
       .figures = {{"sd_um",
                    UmFromMm(noise.sd_mm),
                    UmFromMm(noise.sd_mm) / std::sqrt(2 * noise.dof)}},
       .sentence = fmt::format(
           "One reading repeats to {} um (standard deviation, {} degree{} of freedom "
           "at {} "
           "place{}){}",
           TwoDigits(UmFromMm(noise.sd_mm)),
           static_cast<int>(noise.dof),
           noise.dof == 1 ? "" : "s",
           num_places,
           num_places == 1 ? "" : "s",
           is_wild
               ? ": no part of a machine scatters like that. The trigger is false (a "
                 "loose wire, interference, a floating input), or something slips"
               : ""),
       .is_answer = is_wild});
}

/// One place and sense after the other.
class RepeatReader {
 public:
  RepeatReader(const Rows& rows, Facts* facts)
      : resolution_mm_(FinestStep_mm(rows)),
        is_one_place_(CellsOf(rows, kAnyHome | kAnyCampaign | kAnyFeed).size() == 1),
        facts_(facts) {}

  void Read(const Rows& rows) {
    cells_.push_back(rows);
    if (rows.size() < 2) {
      found_.batches.push_back(rows);
      return;
    }
    const std::vector<Rows> homes = ByHome(rows);
    // One reading a session parts nothing.
    const bool has_batches =
        std::ranges::any_of(homes, [](const Rows& home) { return home.size() > 1; });
    // Of several places, each touched once a session, none is a repeat of another
    // session.
    if (homes.size() > 1 && !has_batches && !is_one_place_) {
      for (const Rows& home : homes) found_.batches.push_back(home);
      return;
    }
    if (homes.size() > 1 && has_batches) {
      AddHomings(homes, /*are_homings=*/true, resolution_mm_, facts_);
      for (const Rows& home : homes) ReadSession(home);
    } else {
      ReadSession(rows);
    }
  }

  // Rows of one place, of several runs (campaigns) and homings.
  void ReadRuns(const Rows& rows) {
    std::vector<Rows> runs;
    for (const Row* row : rows) {
      const bool is_new = runs.empty() || runs.back().back()->campaign != row->campaign;
      if (is_new) runs.emplace_back();
      runs.back().push_back(row);
    }
    if (runs.size() == 1 || ByHome(rows).size() > 1) {
      if (runs.size() == 1) {
        Read(rows);
      } else {
        ReadHomesOfRuns(rows, runs);
      }
      return;
    }
    cells_.push_back(rows);
    if (LeaveOutFirsts(&runs)) {
      for (const Rows& run : runs) found_.batches.push_back(run);
      return;
    }
    const auto whole = DriftOf(rows, resolution_mm_);
    double most_mm = 0;
    for (const Rows& run : runs) {
      const auto own = DriftOf(run, resolution_mm_);
      if (own) most_mm = std::max(most_mm, std::abs(own->change_mm));
    }
    constexpr double kGoesOn = 1.5;
    if (whole && std::abs(whole->change_mm) > kGoesOn * most_mm &&
        ContinuesOver(runs, *whole)) {
      AddDrift(rows, *whole, facts_);
      KeepDrifted(rows, *whole);
      return;
    }
    for (const Rows& run : runs) ReadSession(run);
  }

  // Places that each climb (or fall) from touch to touch, none of them long enough
  // alone.
  void AddCommonDrift() {
    constexpr std::size_t kFewestRows = 4, kFewestPlaces = 2;
    constexpr double kMostChance = 1e-3;
    double sum = 0, variance = 0;
    std::size_t num = 0;
    const Rows* longest = nullptr;
    bool is_alike = true;
    for (const Rows& batch : found_.batches) {
      if (batch.size() < kFewestRows || drifted_.contains(batch.front())) continue;
      const double own = TrendSum(batch);
      is_alike &= own * sum >= 0 && own != 0;
      sum += own;
      variance += TrendVariance(batch);
      ++num;
      if (longest == nullptr || batch.size() > longest->size()) longest = &batch;
    }
    if (num < kFewestPlaces || !is_alike || facts_->Find("drift") != nullptr) return;
    const double z = std::max(0.0, std::abs(sum) - 1) / std::sqrt(variance);
    if (std::erfc(z / std::sqrt(2.0)) > kMostChance) return;
    AddDrift(*longest, ChangeOf(*longest, resolution_mm_), facts_);
    facts_->all.back().sentence +=
        fmt::format(". All {} places with so many touches do the same", num);
  }

  Repeats Take() {
    AddCommonDrift();
    LeaveOutFar(cells_, &found_.batches, resolution_mm_, &found_.outliers);
    constexpr double kEnoughOfCampaign = 5;
    double squares_mm2 = drifted_mm2_, dof = drifted_dof_;
    std::map<std::string, Within> by_campaign;
    for (const Rows& batch : found_.batches) {
      if (batch.size() < 2 || drifted_.contains(batch.front())) continue;
      if (IsWarmed(batch)) continue;  // Readings at other temperatures are no repeats.
      ++num_places_;
      squares_mm2 += SquaresAbout(batch, MeanOf(batch));
      dof += static_cast<double>(batch.size()) - 1;
      Within& own = by_campaign[batch.front()->campaign];
      own.squares_mm2 += SquaresAbout(batch, MeanOf(batch));
      own.dof += static_cast<double>(batch.size()) - 1;
    }
    for (const auto& [campaign, within] : by_campaign) {
      if (within.dof < kEnoughOfCampaign) continue;
      found_.of_campaign[campaign] = {
          .sd_mm = std::max(within.sd_mm(), resolution_mm_ / std::sqrt(12.0)),
          .dof = within.dof};
    }
    if (dof > 0) {
      found_.noise = {.sd_mm = std::max(std::sqrt(squares_mm2 / dof),
                                        resolution_mm_ / std::sqrt(12.0)),
                      .dof = dof};
    }
    return std::move(found_);
  }

  std::size_t num_places() const { return num_places_; }
  /// How far the first touch of every run stands off; 0: it does not.
  double firsts_mm() const { return firsts_mm_; }

 private:
  void ReadSession(const Rows& rows) {
    const auto jump_mm = JumpSize_mm(rows, resolution_mm_);
    std::vector<Rows> levels = {rows};
    if (jump_mm) {
      levels =
          WithoutExcursions(SplitAtJumps(rows, *jump_mm), *jump_mm, &found_.outliers);
    }
    if (!jump_mm || levels.size() > 2) {
      const std::vector<Rows> groups = TwoGroups(rows, resolution_mm_);
      if (!groups.empty()) {
        AddHomings(groups, /*are_homings=*/false, resolution_mm_, facts_);
        for (const Rows& group : groups) found_.batches.push_back(group);
        return;
      }
    }
    if (levels.size() > 2) {
      AddHomings(levels, /*are_homings=*/false, resolution_mm_, facts_);
    } else if (levels.size() == 2 && levels[0].size() > 1 && levels[1].size() > 1) {
      AddJump(levels, facts_);
    }
    for (const Rows& level : levels) {
      const auto drift = DriftOf(level, resolution_mm_);
      if (drift) {
        AddDrift(level, *drift, facts_);
        KeepDrifted(level, *drift);
      } else {
        found_.batches.push_back(level);
      }
    }
  }

  void KeepDrifted(const Rows& rows, const Drift& drift) {
    drifted_.insert(rows.front());
    const double dof = static_cast<double>(rows.size() - 2);
    drifted_mm2_ += dof * drift.noise_mm * drift.noise_mm;
    drifted_dof_ += dof;
    ++num_places_;
    found_.batches.push_back(rows);
  }

  // Homings are told by all runs, scatter by each.
  void ReadHomesOfRuns(const Rows& rows, const std::vector<Rows>& runs) {
    cells_.push_back(rows);
    constexpr std::size_t kFewestHomes = 3;
    std::vector<Rows> batches;
    for (const Rows& run : runs) {
      for (const Rows& home : ByHome(run)) {
        batches.push_back(home);
        ReadSession(home);
      }
    }
    if (ByHome(rows).size() >= kFewestHomes) {
      AddHomings(batches, /*are_homings=*/true, resolution_mm_, facts_);
    }
  }

  // Each run begins about where the one before it ended.
  static bool ContinuesOver(const std::vector<Rows>& runs, const Drift& whole) {
    for (std::size_t k = 1; k < runs.size(); ++k) {
      const double gap_mm =
          std::abs(runs[k].front()->value_mm - runs[k - 1].back()->value_mm);
      if (gap_mm > std::abs(whole.change_mm) / 2) return false;
    }
    return true;
  }

  // The first touch of every run stands off from the rest of it, in the same sense.
  bool LeaveOutFirsts(std::vector<Rows>* runs) {
    constexpr std::size_t kFewestRuns = 2, kFewestRows = 5;
    constexpr double kFar = 4;
    if (runs->size() < kFewestRuns) return false;
    double squares_mm2 = 0, dof = 0, sum_mm = 0;
    std::vector<double> offs_mm;
    for (const Rows& run : *runs) {
      if (run.size() < kFewestRows) return false;
      const Rows rest(run.begin() + 1, run.end());
      squares_mm2 += SquaresAbout(rest, MeanOf(rest));
      dof += static_cast<double>(rest.size()) - 1;
      offs_mm.push_back(run.front()->value_mm - MeanOf(rest));
      sum_mm += offs_mm.back() / static_cast<double>(runs->size());
    }
    const double noise_mm =
        std::max(std::sqrt(squares_mm2 / dof), resolution_mm_ / std::sqrt(12.0));
    for (const double off_mm : offs_mm) {
      if (off_mm * sum_mm <= 0 || std::abs(off_mm) < kFar * noise_mm) return false;
    }
    for (Rows& run : *runs) {
      found_.outliers.insert(run.front()->row);
      run.erase(run.begin());
    }
    firsts_mm_ = sum_mm;
    return true;
  }

  double resolution_mm_;
  bool is_one_place_;
  Facts* facts_;
  Repeats found_{};
  std::vector<Rows> cells_{};       ///< Each place, whatever the homing.
  std::set<const Row*> drifted_{};  ///< First rows of batches that drift.
  double drifted_mm2_ = 0, drifted_dof_ = 0, firsts_mm_ = 0;
  std::size_t num_places_ = 0;
};

}  // namespace

double StatedSigma_mm(const Row& row, const DataHeader& header) {
  if (Known(row.sigma_mm) && row.sigma_mm > 0) return row.sigma_mm;
  const auto campaign = header.campaigns.find(row.campaign);
  if (campaign == header.campaigns.end()) return kUnknown;
  const auto instrument = header.instruments.find(campaign->second.instrument);
  if (instrument == header.instruments.end() || instrument->second.sigma_um <= 0) {
    return kUnknown;
  }
  return MmFromUm(instrument->second.sigma_um);
}

double FinestStep_mm(const std::vector<const Row*>& rows) {
  constexpr double kNothing_mm = 1e-7;  // Below: the rounding of a sum.
  std::vector<double> values_mm;
  for (const Row* row : rows) values_mm.push_back(row->value_mm);
  std::ranges::sort(values_mm);
  double step_mm = 0;
  for (std::size_t i = 1; i < values_mm.size(); ++i) {
    const double gap_mm = values_mm[i] - values_mm[i - 1];
    if (gap_mm > kNothing_mm && (step_mm == 0 || gap_mm < step_mm)) step_mm = gap_mm;
  }
  return step_mm;
}

Repeats FactsOfRepeats(const std::vector<const Row*>& rows,
                       const DataHeader& header,
                       Facts* facts) {
  RepeatReader reader(rows, facts);
  Rows of_bed, others;
  for (const Row* row : rows) {
    (row->kind == RowKind::kTouch && row->setup.starts_with("bed") ? of_bed : others)
        .push_back(row);
  }
  for (const auto& [key, cell] : CellsOf(others, kAnyHome)) reader.Read(cell);
  // Runs of touches of one bed go on where the one before ended.
  std::set<double> feeds;
  for (const Row* row : of_bed) {
    if (Known(row->feed_mm_s)) feeds.insert(row->feed_mm_s);
  }
  const unsigned freedom =
      kAnyHome | kAnyCampaign | (feeds.size() <= 1 ? kAnyFeed : 0U);
  for (const auto& [key, cell] : CellsOf(of_bed, freedom)) {
    reader.ReadRuns(cell);
  }
  Repeats repeats = reader.Take();
  AddOutliers(repeats.outliers, rows, facts);
  if (reader.firsts_mm() != 0) {
    facts->all.back().sentence = fmt::format(
        "The first touch of every run (rows {}) reads {} um {} than the rest of it: it "
        "comes "
        "after another approach (higher, faster, or after a rest). Leave it out, or "
        "make one "
        "touch before the test; it is neither noise nor drift",
        fmt::join(facts->all.back().rows, ", "),
        TwoDigits(UmFromMm(std::abs(reader.firsts_mm()))),
        reader.firsts_mm() > 0 ? "higher" : "lower");
  }
  AddContradiction(repeats.batches, header, facts);
  AddRepeatability(
      repeats.noise, reader.num_places(), rows.front()->kind == RowKind::kTouch, facts);
  if (!Known(repeats.noise.sd_mm)) {
    std::vector<double> stated_mm;
    for (const Row* row : rows) {
      const double sigma_mm = StatedSigma_mm(*row, header);
      if (Known(sigma_mm)) stated_mm.push_back(sigma_mm);
    }
    if (2 * stated_mm.size() > rows.size()) {
      repeats.noise = {.sd_mm = Median(stated_mm), .dof = 0, .is_stated = true};
    }
  }
  return repeats;
}

}  // namespace caltwin
