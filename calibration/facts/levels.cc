#include "calibration/facts/levels.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/estimate/f_test.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kLeastLevel_mm = 0.02;  // Smaller jumps are anybody's.
constexpr double kApart = 8;             // Jumps between levels over scatter within.

}  // namespace

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

double BatchScatter::sd_mm() const {
  return dof > 0 ? std::sqrt(squares_mm2 / dof) : kUnknown;
}

BatchScatter ScatterWithin(const std::vector<Rows>& batches) {
  BatchScatter within;
  for (const Rows& batch : batches) {
    within.squares_mm2 += SquaresAbout(batch, MeanOf(batch));
    within.dof += static_cast<double>(batch.size()) - 1;
  }
  return within;
}

void AddHomings(const std::vector<Rows>& batches,
                bool are_homings,
                double resolution_mm,
                Facts* facts) {
  constexpr double kMostChance = 1e-3;
  BatchScatter within = ScatterWithin(batches);
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
  const BatchScatter within = ScatterWithin(levels);
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

}  // namespace caltwin
