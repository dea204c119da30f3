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
#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/own_shape.h"
#include "calibration/diagnosis/refit.h"
#include "calibration/diagnosis/remains.h"
#include "sim/base/require.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Whether the rows tell how large it is: not where it stands at the end of what is
// possible, nor where it (of several sizes each) may as well be nothing. What a kelvin
// does to a material is known: ten times the usual is something else.
bool HasSize(const Candidate& candidate, const Refined& refined) {
  if (candidate.cause == "homing_scatter") return true;  // Its size is a scatter.
  constexpr double kLeast_sds = 2;
  constexpr double kAtEnd = 1e-6;
  constexpr double kMostOfUsual = 10;
  const auto parameters = EffectAt(candidate.effect).parameters;
  bool is_something = false;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].role != Role::kSize) continue;
    const double size = refined.effect.values[p];
    const double end = kAtEnd * (parameters[p].max - parameters[p].min);
    is_something |= std::abs(size) >= kLeast_sds * refined.sds[p];
    if (size > parameters[p].max - end) return false;
    if (size < parameters[p].min + end) return false;
    const bool is_per_kelvin = parameters[p].unit.find('K') != std::string_view::npos;
    const double of_usual = refined.sizes_mm.norm() / refined.variant.usual_mm;
    if (is_per_kelvin && of_usual > kMostOfUsual) return false;
  }
  return is_something;
}

// Whether the rows last long enough to tell a growth that levels off from a drift with
// no end: its time constant stays within those that they can show.
bool SeesItsEnd(const Candidate& candidate, const Refined& refined) {
  if (candidate.cause != "frame_growth") return true;
  constexpr double kAtEnd = 0.99;
  double longest_s = 0;
  for (const Variant& variant : candidate.variants) {
    longest_s = std::max(longest_s, variant.forms[0]);
  }
  return refined.variant.forms[0] < kAtEnd * longest_s;
}

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

  // Where much remains that the named causes should have explained, where the rows do
  // not tell how large they are, and where a name's own shape is not what the rows
  // show, they lose their names.
  void DoubtNames() {
    constexpr double kLeastShare = 0.7;
    if (found().empty()) return;
    const std::vector<Refined> refined = Refit(observed_, candidates_, search_);
    const std::vector<double> shares =
        GainOf(observed_, candidates_, search_, refined, GainDepth::kBlocks).shares;
    const double explained = std::accumulate(shares.begin(), shares.end(), 0.0);
    for (std::size_t i = found().size(); i-- > 0;) {
      const Candidate& candidate = candidates_[found()[i].candidate];
      if (candidate.is_free()) continue;
      if (found()[i].lost_its_name) {  // No table has its variables.
        found()[i].rivals.clear();
        continue;
      }
      const bool explains_little = explained < kLeastShare && !IsBeyondPrediction(i);
      if (explains_little || !HasSize(candidate, refined[i]) ||
          !SeesItsEnd(candidate, refined[i]) || !ShowsItsShape(i, refined[i])) {
        found()[i].lost_its_name = true;
        SetFree(i);
        MergeEqual(i);
      }
    }
  }

  // A table without a name is of use for what it foretells: where it is no third of
  // what can be, or finer than the motors' steps, it is no finding. What there is to
  // say of it.
  std::string DropUseless() {
    constexpr double kOfUse = 1.0 / 3;
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
      const PlainFit fit = FitPlain(observed_, beside, columns_mm, refined.sizes_mm);
      return LeavesTooMuch(fit, FormOf(candidate, observed_.machine()));
    };
    const bool is_leftover =
        leaves_too_much(CircumstancesBut(i)) && leaves_too_much(PlainBut(i));
    return !is_leftover && !IsResidue(i, refined) &&
           !IsAmongOutliers(observed_, out, candidate, refined.variant) &&
           !IsGradual(observed_, NamedBut(i), candidate);
  }

  // Root sum of squares, in sigma, of what shows of columns beside the rest.
  double ShownOf(const Eigen::MatrixXd& columns_mm, const Circumstances& beside) const {
    const Evidence evidence(
        observed_, {beside.sigma_mm, 0}, beside.nuisances, beside.left_out);
    return evidence.Left(evidence.Whiten(columns_mm)).norm();
  }

  // Plates are no parabolas: where baseline and other findings take up nearly all of a
  // bend, what is left of it may be what its form differs by, and may be anything's. It
  // is a residue unless more of it shows than of what its form may differ by, and the
  // rows prove the shape; beside a table that could be it, they cannot.
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
    if (ShownOf(change_mm, beside) < ShownOf(differs_mm, beside)) return true;
    return !IsProven(FitPlain(observed_, beside, columns_mm, refined.sizes_mm));
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
  scrutiny.DropUnpredictive();
  scrutiny.DoubtNames();
  std::set<std::size_t> shown;
  for (const Found& found : search->found) {
    Require(shown.insert(found.candidate).second, "every finding is another candidate");
  }
  return scrutiny.DropUseless();
}

}  // namespace caltwin
