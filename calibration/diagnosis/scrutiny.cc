#include "calibration/diagnosis/scrutiny.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/gain.h"
#include "calibration/diagnosis/known_size.h"
#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/own_shape.h"
#include "calibration/diagnosis/refit.h"
#include "calibration/diagnosis/remains.h"
#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

const double kSure_nats = std::log(20.0);  // What a name is given or taken at.

class Scrutiny {
 public:
  Scrutiny(const Observed& observed,
           const std::vector<Candidate>& candidates,
           SearchResult* search)
      : observed_(observed), candidates_(candidates), search_(*search) {}

  // Findings that make rows they have not seen no likelier go, the worst first; where
  // all of them together foretell those rows worse, so do the less than certain.
  void DropUnpredictive() {
    constexpr double kWorse = 1.001;  // More than rounding.
    constexpr double kCertain_nats = 16;
    while (!found().empty()) {
      const GainFigures gain = Gain();
      std::vector<double> scores = gain.scores;
      for (std::size_t i = 0; i < scores.size(); ++i) {
        if (IsBeyondPrediction(i)) scores[i] = std::numeric_limits<double>::infinity();
      }
      const auto worst = std::ranges::min_element(scores);
      const bool is_worse = gain.blocks.after_mm > kWorse * gain.blocks.before_mm;
      if (*worst > (is_worse ? kCertain_nats : 0)) return;
      found().erase(found().begin() + (worst - scores.begin()));
    }
  }

  // Two thermometers of one cause stay where they foretell rows left out no worse than
  // the first alone with its freedom of form.
  void PartSiblings() {
    const auto keeps = [](const Found& one) {
      return one.keeps_its_form;
    };
    const auto last = std::ranges::find_if(found().rbegin(), found().rend(), keeps);
    if (last == found().rend()) return;
    const double together_mm = Gain().blocks.after_mm;
    const std::vector<Found> before = found();
    found().erase(std::next(last).base());
    for (Found& one : found()) one.keeps_its_form = false;
    if (Gain().blocks.after_mm > together_mm) found() = before;
  }

  // Names that the rows do not bear out; then, until all stand, names whose size they
  // no longer tell beside the tables that took the place of others. (Shapes were judged
  // beside the names: a table takes up part of any.)
  void DoubtNames() {
    constexpr int kRounds = 8;
    bool is_other = DoubtEach(/*of_all=*/true);
    for (int round = 1; is_other && round < kRounds; ++round) {
      is_other = DoubtEach(/*of_all=*/false);
    }
    for (std::size_t i = 0; i < found().size(); ++i) AddGradual(i);
  }

  // Beside a cause that explains nearly all: what is smaller than the noise of one
  // reading, and a wave that the rows do not show, which only values that are not
  // believed speak for. The worst first.
  void DropSlight() {
    constexpr double kSlightShare = 0.05;
    while (found().size() > 1) {
      const std::vector<Refined> refined = Refit(observed_, candidates_, search_);
      const std::vector<double> shares =
          GainOf(observed_, candidates_, search_, refined, GainDepth::kBlocks).shares;
      std::size_t slightest = found().size();
      for (std::size_t i = 0; i < found().size(); ++i) {
        const bool is_slight =
            shares[i] < kSlightShare && (IsSmall(i, refined[i]) || IsUnseenWave(i));
        const bool is_worse =
            slightest == found().size() || shares[i] < shares[slightest];
        if (is_slight && is_worse) slightest = i;
      }
      if (slightest == found().size()) return;
      found().erase(found().begin() + static_cast<std::ptrdiff_t>(slightest));
    }
  }

  // A table without a name is of use for what it foretells: where it is no third of
  // what can be, or finer than the motors' steps, it is no finding. What there is to
  // say of it.
  std::string DropUseless() {
    constexpr double kOfUse = 1.0 / 3;
    DropUnseenTables();
    std::erase_if(found(), [&](const Found& found) {
      return IsFinerThanAStep(observed_, candidates_, found);
    });
    const bool has_name = std::ranges::any_of(found(), [&](const Found& found) {
      return !candidates_[found.candidate].is_free() && !found.lost_its_name;
    });
    if (found().empty() || has_name) return "";
    const GainFigures gain = Gain();
    const bool is_of_use = gain.explained_fraction >= kOfUse;
    if (is_of_use && !MayBeWander()) return "";
    std::vector<std::string> names;
    for (const Found& found : found()) {
      names.push_back(candidates_[found.candidate].Name());
    }
    found().clear();
    const double before_um = UmFromMm(gain.blocks.before_mm);
    const double after_um = UmFromMm(gain.blocks.after_mm);
    return fmt::format(
        "{} without a name ({}) would foretell rows left out to {} um, the baseline "
        "alone "
        "to {}: {}",
        names.size() == 1 ? "a table" : "tables",
        fmt::join(names, ", "),
        TwoDigits(after_um),
        TwoDigits(before_um),
        is_of_use
            ? "no finding, for no row has a time or is measured again, and a slow "
              "wander of the machine would look like that"
        : after_um < before_um ? "less than a third of what can be, and no finding"
                               : "no better, and no finding");
  }

 private:
  std::vector<Found>& found() { return search_.found; }

  // Whether it does less than the noise of one reading, where it does most.
  bool IsSmall(std::size_t i, const Refined& refined) const {
    const Found& own = search_.found[i];
    const bool is_refitted = refined.effect.effect >= 0;
    const Eigen::VectorXd change_mm =
        is_refitted ? refined.variant.columns_mm * refined.sizes_mm
                    : own.variant.columns_mm * own.sizes_mm;
    return Peak_mm(change_mm.cwiseQuotient(search_.circumstances.sigma_mm)) < 1;
  }

  // A table that the rows fit no better with, which only values that are not believed
  // speak for.
  void DropUnseenTables() {
    constexpr double kNoShare = 0.005;
    if (found().empty()) return;
    const std::vector<double> shares = Gain().shares;
    for (std::size_t i = found().size(); i-- > 0;) {
      const bool is_table =
          candidates_[found()[i].candidate].is_free() || found()[i].lost_its_name;
      if (is_table && shares[i] < kNoShare)
        found().erase(found().begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  bool IsUnseenWave(std::size_t i) const {
    const Candidate& candidate = candidates_[search_.found[i].candidate];
    return !candidate.is_free() && EffectAt(candidate.effect).sight->harmonics > 0 &&
           IsBeyondPrediction(i);
  }

  // Where much remains that the named causes should have explained, where the rows do
  // not tell how large they are, and where a name's own shape is not what the rows
  // show, they lose their names. Whether any did. `of_all`: else of size alone.
  bool DoubtEach(bool of_all) {
    constexpr double kLeastShare = 0.7;
    if (found().empty()) return false;
    const std::vector<Refined> refined = Refit(observed_, candidates_, search_);
    const bool explain_little = of_all && Explained(refined) < kLeastShare;
    bool is_other = false;
    for (std::size_t i = found().size(); i-- > 0;) {
      const Found before = found()[i];
      const Candidate& candidate = candidates_[before.candidate];
      if (candidate.is_free()) continue;
      if (before.lost_its_name) {  // No table has its variables.
        found()[i].rivals.clear();
        continue;
      }
      const bool explains_little = explain_little && !IsBeyondPrediction(i);
      const bool is_there =
          !explains_little && (!of_all || ShowsItsShape(i, refined[i]));
      if (is_there && IsSizeKnown(candidate, refined[i])) continue;
      is_other = true;
      if (!is_there || !GiveToRival(i)) TakeName(i);
    }
    return is_other;
  }

  // Of what can be explained, by all names. A wander of the machine cannot.
  double Explained(const std::vector<Refined>& refined) const {
    if (search_.wander_mm2_per_s == 0) {
      const std::vector<double> shares =
          GainOf(observed_, candidates_, search_, refined, GainDepth::kBlocks).shares;
      return std::accumulate(shares.begin(), shares.end(), 0.0);
    }
    const Circumstances& baseline = search_.circumstances;
    const Noise noise{baseline.sigma_mm, search_.wander_mm2_per_s};
    const auto beyond_noise = [&](const std::vector<Nuisance>& nuisances) {
      const Evidence evidence(observed_, noise, nuisances, baseline.left_out);
      return evidence.chi2() - evidence.dof();
    };
    std::vector<Nuisance> all = baseline.nuisances;
    const auto more = NuisancesOfAll(observed_, candidates_, search_.found);
    all.insert(all.end(), more.begin(), more.end());
    const double before = std::max(beyond_noise(baseline.nuisances), 1e-300);
    return 1 - beyond_noise(all) / before;
  }

  void TakeName(std::size_t i) {
    found()[i].lost_its_name = true;
    SetFree(i);
    MergeEqual(i);
  }

  // The rows do not tell how large it is, but they may tell how large a rival is that
  // explains them about as well: then it stands in its place, with the same set. Of a
  // gantry, whose targets are often spaced evenly, a wave that nobody could see between
  // them would stand for any bend: there a table takes the place.
  bool GiveToRival(std::size_t i) {
    constexpr double kLikely = 0.05;
    if (observed_.machine().kind->axes_are_drives()) return false;
    const Found before = found()[i];
    for (const Rival& rival : before.rivals) {
      const Candidate& other = candidates_[rival.candidate];
      const bool is_found =
          std::ranges::find(found(), rival.candidate, &Found::candidate) !=
          found().end();
      if (other.is_free() || is_found || rival.probability < kLikely) continue;
      const Weighed weighed = Weigh(observed_, {other}, CircumstancesBut(i)).ranked[0];
      Found& instead = found()[i];
      instead.candidate = rival.candidate;
      instead.variant = other.variants[weighed.variant];
      instead.sizes_mm = weighed.sizes_mm;
      instead.scale_mm = weighed.scale_mm;
      instead.probability = rival.probability;
      std::erase(instead.rivals, rival);
      instead.rivals.push_back(
          {.candidate = before.candidate, .probability = before.probability});
      const Refined refined = Refit(observed_, candidates_, search_)[i];
      if (IsSizeKnown(other, refined) && ShowsItsShape(i, refined)) return true;
      found()[i] = before;
    }
    return false;
  }

  // A jump that is not sure to be none of the gradual kind has the table over time as a
  // rival.
  void AddGradual(std::size_t i) {
    constexpr double kDoubtful = 0.05;
    Found& own = found()[i];
    const Candidate& candidate = candidates_[own.candidate];
    if (candidate.is_free() || own.lost_its_name) return;
    const double odds_nats = GradualOdds(observed_, NamedBut(i), candidate);
    const double is_gradual = 1 / (1 + std::exp(-odds_nats));
    if (is_gradual < kDoubtful) return;
    const Found table =
        FreeInstead(observed_, candidates_, CircumstancesBut(i), found()[i]);
    if (!candidates_[table.candidate].is_free()) return;
    std::erase_if(own.rivals, [&](const Rival& rival) {
      return rival.candidate == table.candidate;
    });
    own.rivals.push_back(
        {.candidate = table.candidate, .probability = is_gradual * own.probability});
    own.probability *= 1 - is_gradual;
  }

  GainFigures Gain() const {
    return GainOf(observed_,
                  candidates_,
                  search_,
                  Refit(observed_, candidates_, search_),
                  GainDepth::kBlocks);
  }

  // Without times and without repeats nothing tells a place from a time: what is not
  // far more than noise may be a wander.
  bool MayBeWander() const {
    constexpr int kFewestRepeats = 6;
    const std::vector<int> repeats = PureErrorOf(observed_, 1).dof;
    return !observed_.has_times() &&
           std::accumulate(repeats.begin(), repeats.end(), 0) < kFewestRepeats &&
           !RemainsOf(observed_, search_).IsThere();
  }

  // With all that was found but one in the baseline.
  Circumstances CircumstancesBut(std::size_t except) const {
    Circumstances circumstances = search_.circumstances;
    const auto others = NuisancesOfAll(observed_, candidates_, search_.found, except);
    circumstances.nuisances.insert(
        circumstances.nuisances.end(), others.begin(), others.end());
    return circumstances;
  }

  // With the names but one in the baseline, and no free form that could help it.
  Circumstances NamedBut(std::size_t except) const {
    SearchResult named = search_;
    for (std::size_t i = named.found.size(); i-- > 0;) {
      const bool is_free = candidates_[named.found[i].candidate].is_free();
      if (!is_free && i != except) continue;
      named.found.erase(named.found.begin() + static_cast<std::ptrdiff_t>(i));
    }
    Circumstances circumstances = search_.circumstances;
    const auto others = NuisancesOfAll(observed_, candidates_, named.found);
    circumstances.nuisances.insert(
        circumstances.nuisances.end(), others.begin(), others.end());
    return circumstances;
  }

  // The same, the others without freedom of form: it may take up a small cause beside a
  // large one.
  Circumstances PlainBut(std::size_t except) const {
    Circumstances circumstances = search_.circumstances;
    for (std::size_t i = 0; i < search_.found.size(); ++i) {
      const Found& found = search_.found[i];
      if (i == except) continue;
      auto others = NuisancesOf(observed_, candidates_[found.candidate], found);
      others.resize(static_cast<std::size_t>(found.variant.columns_mm.cols()));
      circumstances.nuisances.insert(
          circumstances.nuisances.end(), others.begin(), others.end());
    }
    return circumstances;
  }

  // What a name must show beside all others: its plain shape, more of it than of
  // anything else; a jump, between rows that can be read.
  bool ShowsItsShape(std::size_t i, const Refined& refined) const {
    if (search_.found[i].lost_its_name) return true;
    const Candidate& candidate = candidates_[search_.found[i].candidate];
    const auto& out = search_.circumstances.left_out;
    const auto leaves_too_much = [&](const Circumstances& beside) {
      const Eigen::MatrixXd& columns_mm = refined.variant.columns_mm;
      const PlainFit fit = FitPlain(
          observed_, beside, search_.wander_mm2_per_s, columns_mm, refined.sizes_mm);
      return LeavesTooMuch(fit, FormOf(candidate, observed_.machine()));
    };
    const bool is_leftover =
        leaves_too_much(CircumstancesBut(i)) && leaves_too_much(PlainBut(i));
    return !is_leftover && !IsResidue(i, refined) &&
           !IsAmongOutliers(observed_, out, candidate, refined.variant) &&
           GradualOdds(observed_, NamedBut(i), candidate) < kSure_nats;
  }

  // Root sum of squares, in sigma, of what shows of columns beside the rest.
  double ShownOf(const Eigen::MatrixXd& columns_mm, const Circumstances& beside) const {
    const Evidence evidence(
        observed_, {beside.sigma_mm, 0}, beside.nuisances, beside.left_out);
    return evidence.Left(evidence.Whiten(columns_mm)).norm();
  }

  // Plates are no parabolas: where baseline and other findings take up nearly all of a
  // bend, what is left of it may be what its form differs by, and may be anything's. It
  // is a residue unless the rows prove the shape; beside a table that could be it, they
  // cannot.
  bool IsResidue(std::size_t i, const Refined& refined) const {
    constexpr double kLeastShown = 0.1;
    const Candidate& candidate = candidates_[search_.found[i].candidate];
    if (FormOf(candidate, observed_.machine()) != Form::kClose) return false;
    const Eigen::MatrixXd& columns_mm = refined.variant.columns_mm;
    const Eigen::VectorXd change_mm = columns_mm * refined.sizes_mm;
    const Circumstances beside = CircumstancesBut(i);
    if (ShownPart(observed_, beside, change_mm) >= kLeastShown) return false;
    if (ShownPart(observed_, NamedBut(i), change_mm) >= kLeastShown) return true;
    const Tolerance free = ToleranceOf(observed_, candidate, refined.variant);
    const Eigen::MatrixXd differs_mm =
        free.columns_mm * free.prior.cwiseSqrt().asDiagonal() * refined.sizes_mm.norm();
    const double of_freedom =
        ShownOf(change_mm, beside) / std::max(ShownOf(differs_mm, beside), 1e-300);
    const PlainFit fit = FitPlain(
        observed_, beside, search_.wander_mm2_per_s, columns_mm, refined.sizes_mm);
    return !IsProven(fit, of_freedom);
  }

  // What unseen rows can say nothing of: homings scatter anew each time, and some
  // causes are known by their size, which the baseline could take but is not believed
  // to have.
  bool IsBeyondPrediction(std::size_t i) const {
    constexpr double kVisible = 9;
    const Found& found = search_.found[i];
    if (candidates_[found.candidate].cause == "homing_scatter") return true;
    const Circumstances others = CircumstancesBut(i);
    const Evidence evidence(
        observed_, {others.sigma_mm, 0}, others.nuisances, others.left_out);
    const Eigen::VectorXd visible =
        evidence.Left(evidence.Whiten(found.variant.columns_mm * found.sizes_mm));
    return visible.squaredNorm() < kVisible;
  }

  void SetFree(std::size_t i) {
    found()[i] = FreeInstead(observed_, candidates_, CircumstancesBut(i), found()[i]);
    found()[i].rivals.clear();
  }

  // Where the table that stands in for a finding was found already, one is enough: it
  // is weighed again without the other beside it.
  void MergeEqual(std::size_t i) {
    for (std::size_t j = 0; j < found().size(); ++j) {
      if (j == i || found()[j].candidate != found()[i].candidate) continue;
      found().erase(found().begin() + static_cast<std::ptrdiff_t>(i));
      SetFree(j > i ? j - 1 : j);
      return;
    }
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  SearchResult& search_;
};

}  // namespace

std::string Scrutinise(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       SearchResult* search) {
  Scrutiny scrutiny(observed, candidates, search);
  scrutiny.PartSiblings();
  scrutiny.DropUnpredictive();
  scrutiny.DoubtNames();
  scrutiny.DropSlight();
  std::set<std::size_t> shown;
  for (const Found& found : search->found) {
    Require(shown.insert(found.candidate).second, "every finding is another candidate");
  }
  return scrutiny.DropUseless();
}

}  // namespace caltwin
