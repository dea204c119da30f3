#include "calibration/facts/repeats.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/drift.h"
#include "calibration/facts/levels.h"
#include "calibration/facts/outliers.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

// The largest step of which both are whole multiples, by Euclid; below a nanometre is
// the rounding of a sum.
double CommonStep_mm(double one_mm, double other_mm) {
  constexpr double kNothing_mm = 1e-6;
  one_mm = std::abs(one_mm);
  other_mm = std::abs(other_mm);
  while (other_mm > kNothing_mm) {
    const double left_mm = std::abs(std::remainder(one_mm, other_mm));
    one_mm = other_mm;
    other_mm = left_mm;
  }
  return one_mm;
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
    LeaveOutFar(cells_, &found_.batches, resolution_mm_, &found_.outliers, facts_);
    double squares_mm2 = drifted_mm2_, dof = drifted_dof_;
    std::map<std::string, BatchScatter> by_campaign;
    std::map<RowKind, BatchScatter> by_kind;
    for (const Rows& batch : found_.batches) {
      if (batch.size() < 2 || drifted_.contains(batch.front())) continue;
      if (IsWarmed(batch)) continue;  // Readings at other temperatures are no repeats.
      ++num_places_;
      squares_mm2 += SquaresAbout(batch, MeanOf(batch));
      dof += static_cast<double>(batch.size()) - 1;
      for (BatchScatter* const own :
           {&by_campaign[batch.front()->campaign], &by_kind[batch.front()->kind]}) {
        own->squares_mm2 += SquaresAbout(batch, MeanOf(batch));
        own->dof += static_cast<double>(batch.size()) - 1;
      }
    }
    KeepEnough(by_campaign, &found_.of_campaign);
    KeepEnough(by_kind, &found_.of_kind);
    if (dof > 0) {
      found_.noise = {.sd_mm = std::max(std::sqrt(squares_mm2 / dof),
                                        resolution_mm_ / std::sqrt(12.0)),
                      .dof = dof};
    }
    return std::move(found_);
  }

  template <typename Key>
  void KeepEnough(const std::map<Key, BatchScatter>& scatters,
                  std::map<Key, ReadingNoise>* noises) const {
    constexpr double kEnough = 5;
    for (const auto& [key, within] : scatters) {
      if (within.dof < kEnough) continue;
      (*noises)[key] = {
          .sd_mm = std::max(within.sd_mm(), resolution_mm_ / std::sqrt(12.0)),
          .dof = within.dof};
    }
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
      const std::vector<Rows> step =
          drift ? AtOneStep(level, resolution_mm_) : std::vector<Rows>{};
      if (!step.empty()) {
        AddJump(step, facts_);
        for (const Rows& side : step) found_.batches.push_back(side);
      } else if (drift) {
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
  constexpr double kCoarsest_mm = 1;
  const bool are_alike = std::ranges::all_of(
      rows, [&](const Row* row) { return row->value_mm == rows.front()->value_mm; });
  if (are_alike) return 0;
  double step_mm = 0;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    const double told_mm =
        axis >= 0 ? row->cmd_mm[static_cast<std::size_t>(axis)] : kUnknown;
    step_mm = CommonStep_mm(step_mm, row->value_mm - rows.front()->value_mm);
    // What was read, where a command stands beside it.
    if (Known(told_mm)) step_mm = CommonStep_mm(step_mm, told_mm + row->value_mm);
  }
  return step_mm > kCoarsest_mm ? CommonStep_mm(step_mm, kCoarsest_mm) : step_mm;
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
