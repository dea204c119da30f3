#include "calibration/diagnosis/search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/beside_table.h"
#include "calibration/diagnosis/gates.h"
#include "calibration/diagnosis/imitators.h"
#include "calibration/diagnosis/own_shape.h"
#include "calibration/diagnosis/stories.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

const double kNamingOdds = std::log(20.0);
constexpr double kPracticalSize_sigma = 0.5;
constexpr double kFormLimit = 0.6;
// Above this no draw of noise was ever seen; the bootstrap would only say 0.
constexpr double kBeyondDoubt_nats = 16;
constexpr double kMostChance = 0.01;
constexpr double kShownProbability = 0.01;
constexpr int kNoiseRounds = 2;
// A free form's prior weight and handicap (stories.h), which freedom of form has not.
constexpr double kFreedomOfForm_nats = kOwnShape_nats + 8;

class Searcher {
 public:
  Searcher(const Observed& observed,
           const std::vector<Candidate>& candidates,
           const SearchOptions& options)
      : observed_(observed),
        candidates_(candidates),
        options_(options),
        tolerances_(observed, candidates) {}

  SearchResult Run() {
    SettleNoise();
    StartWithKnown();
    // What is deleted may be found again: no more rounds than could ever be of use.
    for (int round = 0; round < 2 * options_.most_findings; ++round) {
      if (static_cast<int>(found_.size()) >= options_.most_findings) break;
      auto next = Best({});
      if (!next) next = Sibling();
      if (!next) break;
      found_.push_back(std::move(*next));
      if (found_.size() > 1) {
        Swap(found_.size() - 1);
        DeleteWeak();
      }
      JudgeNoise(Under(found_));
    }
    DropImitated();
    for (std::size_t i = 0; i < found_.size(); ++i) AddRivals(i);
    return Take();
  }

 private:
  std::vector<Nuisance> BaselineAnd(const std::vector<Found>& found,
                                    std::optional<std::size_t> except) const {
    std::vector<Nuisance> nuisances = baseline_;
    const auto more = NuisancesOfAll(observed_, candidates_, found, except);
    nuisances.insert(nuisances.end(), more.begin(), more.end());
    return nuisances;
  }

  Circumstances Under(const std::vector<Found>& found,
                      std::optional<std::size_t> except = {}) const {
    return {sigma_mm_, BaselineAnd(found, except), left_out_};
  }

  Weighing WeighAll(const Circumstances& circumstances) const {
    return Weigh(observed_, candidates_, circumstances, &tolerances_);
  }

  // Sigma of each campaign and outliers, both against the richest model.
  void JudgeNoise(const Circumstances& circumstances) {
    const Weighing weighing = WeighAll(circumstances);
    richest_ = JudgeRows(observed_, candidates_, weighing, circumstances, far_);
    left_out_ = richest_.is_outlier;
    for (std::size_t i = 0; i < suspects_.size(); ++i) {
      if (suspects_[i]) left_out_[i] = true;
    }
    constexpr double kEnoughDof = 6;
    for (Eigen::Index i = 0; i < sigma_mm_.size(); ++i) {
      const auto c = static_cast<std::size_t>(
          observed_.campaign_of()[static_cast<std::size_t>(i)]);
      if (richest_.dof[c] >= kEnoughDof) sigma_mm_[i] = richest_.sigma_mm[c];
    }
    if (found_.empty()) first_ = weighing;
    wander_mm2_per_s_ = weighing.wander_mm2_per_s;
  }

  void SettleNoise() {
    baseline_ = BaselineOf(observed_);
    sigma_mm_ = GuessSigma_mm(observed_, FitBaseline(observed_).left_mm);
    suspects_ = LoneRows(observed_);
    far_.assign(suspects_.size(), false);
    for (Eigen::Index i = 0; i < observed_.num_rows(); ++i) {
      if (!options_.far_rows.contains(observed_.row(i).row)) continue;
      suspects_[static_cast<std::size_t>(i)] = far_[static_cast<std::size_t>(i)] = true;
    }
    left_out_ = suspects_;
    for (int round = 0; round < kNoiseRounds; ++round) JudgeNoise(Under({}));
  }

  // Half a sigma of the rows it reaches.
  bool IsPractical(const Candidate& candidate, const Weighed& weighed) const {
    const Eigen::VectorXd change_mm =
        candidate.variants[weighed.variant].columns_mm * weighed.sizes_mm;
    return Peak_mm(change_mm.cwiseQuotient(sigma_mm_)) >= kPracticalSize_sigma;
  }

  int RowsOf(const Candidate& candidate, const Weighed& weighed) const {
    const Eigen::VectorXd change =
        (candidate.variants[weighed.variant].columns_mm * weighed.sizes_mm)
            .cwiseAbs()
            .cwiseQuotient(sigma_mm_);
    return static_cast<int>((change.array() > 0.05 * change.maxCoeff()).count());
  }

  Found FoundFrom(const Circumstances& circumstances,
                  const Weighing& weighing,
                  const Weighed& weighed) const {
    const Candidate& candidate = candidates_[weighed.candidate];
    const Evidence evidence(
        observed_, {sigma_mm_, wander_mm2_per_s_}, circumstances.nuisances, left_out_);
    Found found{.candidate = weighed.candidate,
                .variant = candidate.variants[weighed.variant],
                .sizes_mm = weighed.sizes_mm,
                .probability = weighed.probability,
                .log_odds = weighed.log_odds,
                .scale_mm = weighed.scale_mm,
                .lost_its_name = FormShare(evidence, candidate, weighed) > kFormLimit,
                .num_rows = RowsOf(candidate, weighed)};
    if (found.lost_its_name) {
      return FreeInstead(observed_, candidates_, circumstances, found);
    }
    for (const Weighed& other : weighing.ranked) {
      if (other.probability >= kShownProbability &&
          other.candidate != weighed.candidate) {
        found.rivals.push_back(
            {.candidate = other.candidate, .probability = other.probability});
      }
    }
    return found;
  }

  // The next cause, all gates passed; none if nothing passes. `except`: the finding to
  // be replaced.
  std::optional<Found> Best(std::optional<std::size_t> except) {
    Circumstances circumstances = Under(found_, except);
    Weighing weighing = WeighAll(circumstances);
    while (!weighing.ranked.empty() && weighing.log_odds_any > kNamingOdds) {
      const Weighed& top = weighing.ranked.front();
      const Candidate& candidate = candidates_[top.candidate];
      if (top.log_odds < 0) return std::nullopt;
      const bool is_new = !IsFound(top.candidate, except) &&
                          !IsBorrowed(observed_, circumstances, candidate, top);
      Support support;
      if (is_new && IsPractical(candidate, top)) {
        support =
            SupportOf(observed_, circumstances, wander_mm2_per_s_, candidate, top);
      }
      if (!support.is_by_many && Suspect(support.loudest)) {
        circumstances = Under(found_, except);
        weighing = WeighAll(circumstances);
        continue;
      }
      if (support.is_by_many) {
        if (!IsBeyondChance(circumstances, weighing)) return std::nullopt;
        Found found = FoundFrom(circumstances, weighing, Nameable(&weighing, except));
        // A free form that stands in for it may be there already.
        const bool is_finer = IsFinerThanAStep(observed_, candidates_, found);
        if (!is_finer && !IsFound(found.candidate, except)) return found;
      }
      DropLikeliest(&weighing);
    }
    return std::nullopt;
  }

  bool AreSiblings(std::size_t one, std::size_t other) const {
    const Candidate &a = candidates_[one], &b = candidates_[other];
    return !a.is_free() && a.cause == b.cause && a.axis != b.axis &&
           a.shown.covariates == b.shown.covariates;
  }

  double LogNone(const Circumstances& circumstances) const {
    return Evidence(observed_,
                    {sigma_mm_, wander_mm2_per_s_},
                    circumstances.nuisances,
                    left_out_)
        .log_none();
  }

  // What a second thermometer explains may hide in the freedom of form of the first,
  // where both rise together. Found where the first with its freedom explains the rows
  // not clearly better than both at their exact forms; both then keep theirs.
  std::optional<Found> Sibling() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i].lost_its_name || found_[i].keeps_its_form) continue;
      const double least = LogNone(Under(found_)) - kFreedomOfForm_nats;
      for (std::size_t c = 0; c < candidates_.size(); ++c) {
        if (!AreSiblings(found_[i].candidate, c) || IsFound(c, {})) continue;
        auto found = BesideExact(i, c, least);
        if (found) return found;
      }
    }
    return std::nullopt;
  }

  // A sibling beside the i-th finding, which takes its likeliest form beside it (its
  // lag); none where both explain the rows less than `least`.
  std::optional<Found> BesideExact(std::size_t i, std::size_t sibling, double least) {
    const Found before = found_[i];
    found_[i].keeps_its_form = true;
    std::optional<Variant> likeliest;
    for (const Variant& variant : candidates_[before.candidate].variants) {
      found_[i].variant = variant;
      const Circumstances beside = Under(found_);
      const Weighing weighing = Weigh(observed_, {candidates_[sibling]}, beside);
      const double together = LogNone(beside) + weighing.ranked[0].log_odds;
      if (together <= least) continue;
      least = together;
      likeliest = variant;
    }
    if (likeliest) {
      found_[i].variant = *likeliest;
      const Circumstances beside = Under(found_);
      Weighed weighed = Weigh(observed_, {candidates_[sibling]}, beside).ranked[0];
      const bool stands =
          weighed.log_odds > kNamingOdds &&
          IsPractical(candidates_[sibling], weighed) &&
          SupportOf(observed_, beside, wander_mm2_per_s_, candidates_[sibling], weighed)
              .is_by_many;
      weighed.candidate = sibling;
      Found found = FoundFrom(beside, {}, weighed);
      found.keeps_its_form = true;
      if (stands && !found.lost_its_name) return found;
    }
    found_[i] = before;
    return std::nullopt;
  }

  // A row that alone makes a cause of itself is an outlier, though a model as rich as
  // the candidates may pass through it. False: no more may be left out.
  bool Suspect(std::optional<std::size_t> row) {
    constexpr double kMostSuspects = 0.02;
    const auto most = kMostSuspects * static_cast<double>(suspects_.size());
    const auto have = std::ranges::count(suspects_, true);
    if (!row || suspects_[*row] || static_cast<double>(have) >= most) return false;
    suspects_[*row] = true;
    left_out_[*row] = true;
    return true;
  }

  // What may be reported of the likeliest: where a free form, prior weights and
  // handicap apart, explains the rows about as well as a name, the name is one story of
  // many, and both are as likely.
  const Weighed& Nameable(Weighing* weighing, std::optional<std::size_t> except) const {
    Weighed& top = weighing->ranked.front();
    if (candidates_[top.candidate].is_free()) {
      const auto name = std::ranges::find_if(weighing->ranked, [&](const Weighed& one) {
        return !candidates_[one.candidate].is_free() && !IsFound(one.candidate, except);
      });
      const bool is_name =
          name != weighing->ranked.end() && TwoNamesTell(*weighing, *name, top, except);
      return is_name ? *name : top;
    }
    for (Weighed& other : weighing->ranked) {
      const Candidate& free = candidates_[other.candidate];
      if (!free.is_free() || IsFound(other.candidate, {})) continue;
      // Beyond the usual margin only what would be a finding by itself; and not on a
      // printer, whose nozzle touches along one axis alone.
      const bool stands_alone =
          other.log_odds > kNamingOdds && observed_.machine().kind->axes_are_drives();
      const double margin =
          stands_alone ? MarginOver(candidates_[top.candidate], free) : kOwnShape_nats;
      if (other.log_odds <= top.log_odds - margin) continue;
      if (TwoNamesTell(*weighing, top, other, except)) continue;
      const double together = top.probability + other.probability;
      top.probability = other.probability = together / 2;
      return other;
    }
    return top;
  }

  // Whether a free form in two variables tells no more than this and the next name do.
  bool TwoNamesTell(const Weighing& weighing,
                    const Weighed& name,
                    const Weighed& form,
                    std::optional<std::size_t> except) const {
    const Candidate& free = candidates_[form.candidate];
    if (free.shown.covariates.size() < 2 ||
        !IsPractical(candidates_[name.candidate], name)) {
      return false;
    }
    std::vector<Found> found = found_;
    if (except) found.erase(found.begin() + static_cast<std::ptrdiff_t>(*except));
    found.push_back(FoundFrom(Under(found), weighing, name));
    if (found.back().lost_its_name) return false;
    const double margin = MarginOver(candidates_[name.candidate], free);
    for (const Weighed& next : WeighAll(Under(found)).ranked) {
      const Candidate& candidate = candidates_[next.candidate];
      if (name.log_odds + next.log_odds < form.log_odds + margin) break;
      const bool is_another = next.candidate != name.candidate && !candidate.is_free();
      if (is_another && next.log_odds > kNamingOdds &&
          !IsFound(next.candidate, except) && IsPractical(candidate, next)) {
        return true;
      }
    }
    return false;
  }

  // A cause is found once; twice, at other lags or periods, it only mends its form.
  bool IsFound(std::size_t candidate, std::optional<std::size_t> except) const {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (i != except && found_[i].candidate == candidate) return true;
    }
    return false;
  }

  bool IsBeyondChance(const Circumstances& circumstances,
                      const Weighing& weighing) const {
    if (weighing.log_odds_any > kBeyondDoubt_nats) return true;
    return ChanceUnderNone(observed_,
                           candidates_,
                           circumstances,
                           wander_mm2_per_s_,
                           weighing.log_odds_any,
                           options_.seed) <= kMostChance;
  }

  // What was found at another baseline, each of it beside those before it.
  void StartWithKnown() {
    for (const std::string& name : options_.start) {
      const auto known = std::ranges::find(candidates_, name, &Candidate::Name);
      if (known == candidates_.end()) continue;
      const Circumstances beside = Under(found_);
      Weighed weighed = Weigh(observed_, {*known}, beside).ranked[0];
      weighed.candidate = static_cast<std::size_t>(known - candidates_.begin());
      Found found = FoundFrom(beside, {}, weighed);
      if (!IsFound(found.candidate, {})) found_.push_back(std::move(found));
    }
    if (found_.empty()) return;
    Swap(/*first_seen=*/0);
    DeleteWeak();
    JudgeNoise(Under(found_));
  }

  // With the others in place, each finding may turn out to be another cause; where one
  // did, the others may again. From `first_seen` on, they were found beside all others.
  void Swap(std::size_t first_seen) {
    constexpr int kSwapRounds = 3;
    std::size_t num = first_seen > 0 ? first_seen : found_.size();
    for (int round = 0; round < kSwapRounds; ++round) {
      bool is_other = false;
      for (std::size_t i = 0; i < num; ++i) is_other |= SwapOne(i);
      if (!is_other) return;
      num = found_.size();
    }
  }

  bool SwapOne(std::size_t i) {
    if (found_[i].keeps_its_form) return false;  // They stand or fall together.
    auto better = Best(i);
    if (!better || IsFound(better->candidate, i)) return false;
    const bool is_other = better->candidate != found_[i].candidate;
    found_[i] = std::move(*better);
    return is_other;
  }

  void DeleteWeak() {
    for (std::size_t i = 0; i < found_.size();) {
      const Weighing alone =
          Weigh(observed_, {candidates_[found_[i].candidate]}, Under(found_, i));
      if (alone.ranked[0].log_odds < kNamingOdds) {
        found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
      } else {
        ++i;
      }
    }
    for (Found& one : found_) {
      one.keeps_its_form &= std::ranges::any_of(found_, [&](const Found& other) {
        return AreSiblings(one.candidate, other.candidate);
      });
    }
  }

  // A free form found beside a named cause may be that cause's deviation from its form:
  // where it outgrows the limit, the name goes.
  void DropImitated() {
    for (std::size_t i = 0; i < found_.size();) {
      const Candidate& own = candidates_[found_[i].candidate];
      bool is_imitated = false;
      for (std::size_t k = 0; k < found_.size() && !own.is_free(); ++k) {
        is_imitated |= candidates_[found_[k].candidate].is_free() &&
                       StandsForBoth(observed_, candidates_, Under({}), found_, k, i);
      }
      if (is_imitated) {
        found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
        Reweigh();
      } else {
        ++i;
      }
    }
  }

  // The sizes of all that is left, each with the others in place.
  void Reweigh() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const Weighing again =
          Weigh(observed_, {candidates_[found_[i].candidate]}, Under(found_, i));
      found_[i].sizes_mm = again.ranked[0].sizes_mm;
      found_[i].scale_mm = again.ranked[0].scale_mm;
    }
  }

  void AddRivals(std::size_t i) {
    if (candidates_[found_[i].candidate].is_free() || found_[i].lost_its_name) return;
    AddImitators(
        observed_,
        candidates_,
        {observed_, {sigma_mm_, wander_mm2_per_s_}, BaselineAnd(found_, i), left_out_},
        i,
        &found_);
  }

  SearchResult Take() const {
    return {.found = found_,
            .circumstances = {sigma_mm_, baseline_, left_out_},
            .first = first_,
            .richest = richest_,
            .wander_mm2_per_s = wander_mm2_per_s_};
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  SearchOptions options_;
  mutable Tolerances tolerances_;
  std::vector<Nuisance> baseline_{};
  Eigen::VectorXd sigma_mm_{};
  std::vector<bool> left_out_{};
  std::vector<bool> suspects_{};  ///< Of them, those that the search met.
  std::vector<bool> far_{};       ///< SearchOptions::far_rows.
  std::vector<Found> found_{};
  Weighing first_{};
  Richest richest_{};
  double wander_mm2_per_s_ = 0;
};

}  // namespace

SearchResult Search(const Observed& observed,
                    const std::vector<Candidate>& candidates,
                    const SearchOptions& options) {
  return Searcher(observed, candidates, options).Run();
}

}  // namespace caltwin
