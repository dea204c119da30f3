#include "calibration/diagnosis/diagnosis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "calibration/diagnosis/atlas.h"
#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/bent.h"
#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/jump_size.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/name_by_facts.h"
#include "calibration/diagnosis/next_campaign.h"
#include "calibration/diagnosis/nothing_found.h"
#include "calibration/diagnosis/pitch_map.h"
#include "calibration/diagnosis/remains.h"
#include "calibration/diagnosis/scrutiny.h"
#include "calibration/diagnosis/stated_noise.h"
#include "calibration/diagnosis/time_noise.h"
#include "calibration/diagnosis/whole_tables.h"
#include "calibration/facts/repeats.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kAmbiguousAbove = 0.05;
constexpr std::size_t kKnotsAlone = 33;
constexpr std::size_t kKnotsOfTwo = 13;
constexpr double kSecondsPerHour = 3600;

// A free form's values on a grid of knots.
FreeMap MapOf(const Observed& observed,
              const Candidate& candidate,
              const Found& found,
              const Eigen::VectorXd& sizes_mm) {
  FreeMap map{.channel = candidate.shown.channel,
              .covariates = candidate.shown.covariates};
  if (!candidate.is_free()) return map;
  std::vector<Covariate> covariates;
  for (const std::string& word : candidate.shown.covariates) {
    covariates.push_back(*CovariateOf(observed, word));
    const Covariate& c = covariates.back();
    const std::size_t num = c.word.starts_with("dir_")               ? 2
                            : candidate.shown.covariates.size() == 1 ? kKnotsAlone
                                                                     : kKnotsOfTwo;
    std::vector<double> knots;
    for (std::size_t k = 0; k < num; ++k) {
      knots.push_back(c.min + (c.max - c.min) * static_cast<double>(k) /
                                  static_cast<double>(num - 1));
    }
    map.knots.push_back(knots);
  }
  map.terms = static_cast<int>(sizes_mm.size());
  map.prior_size_um = UmFromMm(found.scale_mm);
  const std::vector<FreeTerm>& terms = candidate.free_terms;
  const auto value = [&](const std::vector<double>& at) {
    double sum_mm = 0;
    for (Eigen::Index k = 0; k < sizes_mm.size(); ++k) {
      sum_mm +=
          sizes_mm[k] * ProductAt(terms[static_cast<std::size_t>(k)], covariates, at);
    }
    return sum_mm;
  };
  for (const double first : map.knots[0]) {
    if (map.knots.size() == 1) {
      map.values_um.push_back(UmFromMm(value({first})));
      continue;
    }
    for (const double second : map.knots[1]) {
      map.values_um.push_back(UmFromMm(value({first, second})));
    }
  }
  return map;
}

class Reporter {
 public:
  Reporter(const Observed& observed,
           const std::vector<Candidate>& candidates,
           const SearchResult& search)
      : observed_(observed),
        candidates_(candidates),
        search_(search),
        noise_{search.circumstances.sigma_mm, search.wander_mm2_per_s} {}

  Diagnosis Make() {
    refined_ = Refit(observed_, candidates_, search_);
    FitAll();
    Diagnosis diagnosis{.gain = GainOf(observed_, candidates_, search_, refined_)};
    AddEvidence(&diagnosis);
    for (std::size_t i = 0; i < search_.found.size(); ++i) {
      diagnosis.findings.push_back(FindingOf(i, diagnosis.gain));
    }
    std::ranges::stable_sort(
        diagnosis.findings, std::ranges::greater{}, &Finding::share);
    diagnosis.verdict = VerdictOf(diagnosis.findings);
    for (Eigen::Index i = 0; i < observed_.num_rows(); ++i) {
      if (search_.circumstances.left_out[static_cast<std::size_t>(i)]) {
        diagnosis.outlier_rows.push_back(observed_.row(i).row);
      }
    }
    diagnosis.wander_um_per_sqrt_h =
        UmFromMm(std::sqrt(search_.wander_mm2_per_s * kSecondsPerHour));
    AddBaseline(&diagnosis);
    for (const AtlasCause& line : AbsorbedOf(observed_,
                                             candidates_,
                                             search_.circumstances.sigma_mm,
                                             search_.circumstances.nuisances)) {
      const bool is_found = std::ranges::any_of(search_.found, [&](const Found& found) {
        return candidates_[found.candidate].Name() == line.Name();
      });
      if (!is_found) diagnosis.absorbed.push_back({line.Name(), line.into});
    }
    DiagnosedAs(observed_.machine()).AddUnseen(observed_, candidates_, &diagnosis);
    diagnosis.next_campaign = BestNext(observed_, candidates_, search_, /*seed=*/1);
    return diagnosis;
  }

 private:
  // Baseline and findings together, and how much less sure each is because what they
  // leave hangs together in time.
  void FitAll() {
    all_ = search_.circumstances.nuisances;
    std::vector<std::size_t> first;
    for (std::size_t i = 0; i < search_.found.size(); ++i) {
      Found found = search_.found[i];
      if (refined_[i].effect.effect >= 0) found.variant = refined_[i].variant;
      first.push_back(all_.size());
      const auto more = NuisancesOf(observed_, candidates_[found.candidate], found);
      all_.insert(all_.end(), more.begin(), more.end());
    }
    spread_ = TimeNoise(observed_, noise_, all_, search_.circumstances.left_out)
                  .of_nuisances();
    for (std::size_t i = 0; i < first.size(); ++i) {
      const Eigen::Index num =
          std::max(refined_[i].variant.columns_mm.cols(), refined_[i].half_mm.rows());
      if (num == 0) continue;
      const double spread =
          spread_.segment(static_cast<Eigen::Index>(first[i]), num).maxCoeff();
      for (double& sd : refined_[i].sds) sd *= spread;
      refined_[i].half_mm *= spread;
    }
  }

  Finding FindingOf(std::size_t i, const GainFigures& gain) const {
    const Found& found = search_.found[i];
    const Candidate& candidate = candidates_[found.candidate];
    const bool is_free = candidate.is_free() || found.lost_its_name;
    const bool is_map = IsPitchMap(observed_, candidate, gain);
    Finding finding{.cause = is_map    ? "pitch_map"
                             : is_free ? "unknown"
                                       : candidate.cause,
                    .axis = is_free ? candidate.shown.channel : candidate.axis,
                    .probability = found.probability,
                    .log_odds = found.log_odds,
                    .share = gain.shares[i],
                    .covariates = candidate.shown.covariates,
                    .is_by_order = !observed_.has_times(),
                    .rows = found.num_rows};
    if (is_free) {
      const Eigen::VectorXd& sizes_mm =
          candidate.is_free() ? refined_[i].sizes_mm : found.sizes_mm;
      finding.change_mm = found.variant.columns_mm * sizes_mm;
      finding.map = MapOf(observed_, candidate, found, sizes_mm);
      if (candidate.is_free()) finding.map->parts = PartsOf(i);
    } else {
      const Refined& refined = refined_[i];
      finding.effect = refined.effect;
      finding.sds = refined.sds;
      finding.change_mm = refined.variant.columns_mm * refined.sizes_mm;
      const auto parameters = EffectAt(candidate.effect).parameters;
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        finding.parameters.push_back({std::string(parameters[p].name),
                                      refined.effect.values[p],
                                      refined.sds[p]});
      }
    }
    finding.peak_um = UmFromMm(Peak_mm(finding.change_mm));
    finding.candidates.push_back(
        {finding.cause, finding.axis, finding.probability, false});
    for (const Rival& rival : found.rivals) {
      const Candidate& other = candidates_[rival.candidate];
      const bool is_rival_map = IsPitchMap(observed_, other, gain);
      finding.candidates.push_back({is_rival_map ? "pitch_map" : other.cause,
                                    other.axis,
                                    rival.probability,
                                    rival.structural});
    }
    return finding;
  }

  std::vector<TablePart> PartsOf(std::size_t i) const {
    const Found& found = search_.found[i];
    const Candidate& candidate = candidates_[found.candidate];
    std::vector<Covariate> covariates;
    for (const std::string& word : candidate.shown.covariates) {
      covariates.push_back(*CovariateOf(observed_, word));
    }
    const Eigen::VectorXd shows = ChannelOf(observed_, candidate.shown.channel);
    std::vector<bool> is_of_it;
    for (Eigen::Index k = 0; k < shows.size(); ++k) {
      is_of_it.push_back(shows[k] != 0 &&
                         !search_.circumstances.left_out[static_cast<std::size_t>(k)]);
    }
    return PartsOfTable(covariates,
                        candidate.free_terms,
                        {refined_[i].sizes_mm, refined_[i].half_mm},
                        is_of_it);
  }

  void AddEvidence(Diagnosis* diagnosis) const {
    constexpr std::size_t kLines = 12;
    for (const Weighed& weighed : search_.first.ranked) {
      const Candidate& candidate = candidates_[weighed.candidate];
      diagnosis->weighed.push_back({candidate.cause,
                                    candidate.axis,
                                    candidate.shown.covariates,
                                    weighed.log_odds,
                                    candidate.shown.channel});
    }
    diagnosis->evidence = diagnosis->weighed;
    diagnosis->evidence.resize(std::min(kLines, diagnosis->evidence.size()));
    diagnosis->sigma_mm = search_.circumstances.sigma_mm;
  }

  static DiagnosisVerdict VerdictOf(const std::vector<Finding>& findings) {
    DiagnosisVerdict verdict = DiagnosisVerdict::kNone;
    for (const Finding& finding : findings) {
      DiagnosisVerdict one = DiagnosisVerdict::kNamed;
      for (std::size_t c = 1; c < finding.candidates.size(); ++c) {
        const FindingCandidate& rival = finding.candidates[c];
        if (rival.structural || rival.probability > kAmbiguousAbove) {
          one = DiagnosisVerdict::kAmbiguous;
        }
      }
      if (finding.cause == "unknown") one = DiagnosisVerdict::kUnknownStructure;
      verdict = std::max(verdict, one);
    }
    return verdict;
  }

  void AddBaseline(Diagnosis* diagnosis) const {
    const std::vector<Nuisance>& baseline = search_.circumstances.nuisances;
    const auto& out = search_.circumstances.left_out;
    Evidence::Fit with = Evidence(observed_, noise_, all_, out).FitNuisances();
    with.sds.array() *= spread_.array();
    diagnosis->residual_after_mm = with.residual_mm;
    diagnosis->residual_before_mm =
        Evidence(observed_, noise_, baseline, out).FitNuisances().residual_mm;
    const std::vector<Nuisance> kept =
        LinesBesideTables(observed_, candidates_, search_);
    for (std::size_t k = 0; k < baseline.size(); ++k) {
      if (!baseline[k].reported) continue;
      const auto at = static_cast<Eigen::Index>(k);
      const bool is_kept =
          std::ranges::find(kept, baseline[k].name, &Nuisance::name) != kept.end();
      diagnosis->baseline.push_back(
          {baseline[k].name,
           baseline[k].unit,
           baseline[k].offset + with.values[at],
           with.sds[at],
           is_kept && IsDetermined(baseline[k], with.sds[at])});
      if (baseline[k].name == "endstop.b") AddLastEndstop(with, at, diagnosis);
    }
    if (HasNoRowToSpare(baseline)) ForgetHowSure(diagnosis);
  }

  // As many unknowns as rows pass through all of them, and nothing is left that would
  // tell how far a reading strays; unless it was stated.
  bool HasNoRowToSpare(const std::vector<Nuisance>& baseline) const {
    Eigen::Index used = 0;
    for (Eigen::Index i = 0; i < observed_.num_rows(); ++i) {
      if (search_.circumstances.left_out[static_cast<std::size_t>(i)]) continue;
      if (Known(StatedSigma_mm(observed_.row(i), observed_.header()))) return false;
      ++used;
    }
    return used <= std::ssize(baseline);
  }

  static void ForgetHowSure(Diagnosis* diagnosis) {
    for (BaselineLine& line : diagnosis->baseline) {
      line.sd = kUnknown;
      line.is_determined = false;
    }
    diagnosis->remarks.emplace_back(
        "The baseline has as many unknowns as these rows have readings: it passes "
        "through all of them, and how sure any line of it is, or whether the model "
        "holds, is not known. Touch twice as many places");
  }

  // The three of them sum to nought. `b`: which nuisance the second is; the first
  // stands before it.
  static void AddLastEndstop(const Evidence::Fit& fit,
                             Eigen::Index b,
                             Diagnosis* diagnosis) {
    const std::size_t num = diagnosis->baseline.size();
    const BaselineLine& first = diagnosis->baseline[num - 2];
    const BaselineLine& second = diagnosis->baseline[num - 1];
    const double sd = (fit.half.row(b - 1) + fit.half.row(b)).norm();
    diagnosis->baseline.push_back({"endstop.c",
                                   first.unit,
                                   -first.value - second.value,
                                   sd,
                                   first.is_determined && second.is_determined});
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const SearchResult& search_;
  Noise noise_;
  std::vector<Refined> refined_{};
  std::vector<Nuisance> all_{};
  Eigen::VectorXd spread_{};  ///< Of each of `all_`.
};

// The same again at another baseline, beginning with what was found at this one: there
// the residual is another, and a table that fits it at first sight would hide the
// names.
SearchOptions Again(const SearchOptions& options,
                    const std::vector<Candidate>& candidates,
                    const SearchResult& search) {
  SearchOptions again = options;
  again.start.clear();
  for (const Found& found : search.found) {
    again.start.push_back(candidates[found.candidate].Name());
  }
  return again;
}

// Beside the drawing, what is not straight in its sizes leaves the rest of itself as a
// finding or as noise: searched again with columns that lead to where it was found.
void WeighWhereFound(const Observed& observed,
                     const SearchOptions& options,
                     std::vector<Candidate>* candidates,
                     SearchResult* search) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Bent> bent = Bend(observed, *candidates, *search);
    if (!TakeWhereFound(bent, *search, candidates)) return;
    *search = Search(observed, *candidates, Again(options, *candidates, *search));
  }
}

// Whether rows are enough for a model of the machine, and near enough to one: an axis
// that moves twice what it is told is set right first.
bool IsForAModel(const Facts& facts, Eigen::Index num_rows) {
  constexpr Eigen::Index kFewest = 5, kFewestOfOnePlace = 60;
  if (num_rows < kFewest || facts.Find("known_ratio") != nullptr) return false;
  // A few readings of one place tell no part of a machine from another.
  const bool has_answer =
      std::ranges::any_of(facts.all, [](const Fact& fact) { return fact.is_answer; });
  return !facts.is_one_place || !has_answer || num_rows >= kFewestOfOnePlace;
}

// Rows that are bad by themselves, so long as they are few: those off a surface, and
// several off their repeats, which may hide each other. One alone the search meets by
// itself.
std::set<std::int64_t> FarRows(const Facts& facts, Eigen::Index num_rows) {
  constexpr double kMost = 0.2;
  std::set<std::int64_t> far;
  bool is_of_surface = false;
  for (const Fact& fact : facts.all) {
    if (fact.id != "outliers") continue;
    far.insert(fact.rows.begin(), fact.rows.end());
    is_of_surface |= fact.word == "surface";
  }
  const bool may_hide = is_of_surface || far.size() > 1;
  const bool are_few =
      static_cast<double>(far.size()) <= kMost * static_cast<double>(num_rows);
  return may_hide && are_few ? far : std::set<std::int64_t>();
}

}  // namespace

void NameByFacts(Diagnosis* diagnosis) {
  const bool is_named = diagnosis->verdict == DiagnosisVerdict::kNamed;
  bool is_open = !diagnosis->findings.empty() && !is_named;
  if (is_named || diagnosis->is_extended) return;
  const std::vector<std::string>& open = diagnosis->facts.not_determined;
  const bool are_sizes = std::ranges::find(open, "scale") != open.end();
  for (const Fact& fact : diagnosis->facts.all) {
    constexpr std::array kOpen = {"plane",
                                  "form",
                                  "drift",
                                  "jump",
                                  "homing_scatter",
                                  "offset",
                                  "outliers",
                                  "levelling"};
    if (fact.cause.empty()) {
      is_open |= std::ranges::find(kOpen, fact.id) != kOpen.end() ||
                 (fact.id == "repeatability" && fact.is_answer) ||
                 fact.id == "contradiction" ||
                 (fact.id == "scale" && fact.is_answer && are_sizes);
      continue;
    }
    const bool is_elsewhere = !diagnosis->facts.not_the_machine.reason.empty();
    if (!diagnosis->findings.empty() || (fact.cause == "unknown" && is_elsewhere)) {
      continue;
    }
    constexpr double kSure = 0.99;
    Finding finding{.cause = fact.cause,
                    .axis = fact.cause_axis,
                    .probability = kSure,
                    .candidates = {{fact.cause, fact.cause_axis, kSure, false}},
                    .share = 1,
                    .rows = static_cast<int>(fact.rows.size()),
                    .is_of_facts = true};
    for (const FactFigure& figure : fact.parameters) {
      finding.parameters.push_back({figure.key, figure.value, figure.sd});
    }
    // What comes anew each time, that the catalogue has no name for.
    const bool has_name = fact.cause != "unknown";
    if (!has_name) finding.covariates = {"t"};
    is_open |= !has_name;
    diagnosis->findings.push_back(std::move(finding));
    diagnosis->verdict =
        has_name ? DiagnosisVerdict::kNamed : DiagnosisVerdict::kUnknownStructure;
  }
  if (!is_open || diagnosis->verdict == DiagnosisVerdict::kNamed) return;
  diagnosis->facts.not_determined.emplace_back("cause");
  diagnosis->facts.cannot.emplace_back(
      "which part of the machine does it: the numbers show what happens, not why");
}

namespace {

// The answer of rows that no model is fitted to: what they say by themselves.
Diagnosis WithoutModel(const Observed& observed, const Facts& facts) {
  Diagnosis diagnosis{.facts = facts};
  diagnosis.residual_before_mm = observed.residual_mm();
  diagnosis.residual_after_mm = observed.residual_mm();
  diagnosis.sigma_mm = Eigen::VectorXd::Ones(observed.num_rows());
  const double rows =
      static_cast<double>(std::max<Eigen::Index>(1, observed.num_rows()));
  diagnosis.gain.blocks.before_mm = diagnosis.gain.blocks.after_mm =
      observed.residual_mm().norm() / std::sqrt(rows);
  const Fact* repeats = facts.Find("repeatability");
  if (repeats != nullptr) {
    diagnosis.gain.noise_floor_mm = MmFromUm(repeats->figures[0].value);
    diagnosis.gain.floor_from_replicates = true;
  }
  std::set<std::int64_t> far;
  for (const Fact& fact : facts.all) {
    if (fact.id == "outliers") far.insert(fact.rows.begin(), fact.rows.end());
  }
  diagnosis.outlier_rows.assign(far.begin(), far.end());
  diagnosis.has_model = false;
  for (const Fact& fact : facts.all) {
    const bool is_gap = fact.id == "reversal";
    if (!is_gap && fact.id != "scale") continue;
    const FactFigure& figure = fact.figures[0];
    diagnosis.baseline.push_back(
        {.name = (is_gap ? "backlash." : "scale.") + fact.axis,
         .unit = is_gap ? "mm" : "ppm",
         .value = is_gap ? MmFromUm(figure.value) : PpmFromFraction(figure.value - 1),
         .sd = is_gap ? MmFromUm(figure.sd) : PpmFromFraction(figure.sd)});
  }
  NameByFacts(&diagnosis);
  return diagnosis;
}

// Lines of the baseline that the rows cannot determine, whatever their fit says: equal
// readings would make anything certain.
void LeaveOpen(const Facts& facts, std::vector<BaselineLine>* baseline) {
  for (BaselineLine& line : *baseline) {
    if (std::ranges::find(facts.at_one_place, line.name) != facts.at_one_place.end()) {
      line.is_determined = false;
    }
    if (!line.is_determined) line.sd = kUnknown;
  }
}

}  // namespace

std::string ToString(DiagnosisVerdict verdict) {
  switch (verdict) {
    case DiagnosisVerdict::kNone:
      return "none";
    case DiagnosisVerdict::kNamed:
      return "named";
    case DiagnosisVerdict::kAmbiguous:
      return "ambiguous";
    case DiagnosisVerdict::kUnknownStructure:
      break;
  }
  return "unknown";
}

Diagnosis Diagnose(const Observed& as_read, const DiagnoseOptions& asked) {
  DiagnoseOptions options = asked;
  const auto say = [&](const std::string& text) {
    if (options.progress) options.progress(text);
  };
  const Facts facts =
      FactsOf(as_read.table(), as_read.header(), options.levelling, options.has_places);
  if (!options.has_machine || !options.has_places ||
      !IsForAModel(facts, as_read.num_rows())) {
    return WithoutModel(as_read, facts);
  }
  options.search.far_rows = FarRows(facts, as_read.num_rows());
  Observed observed = AtBaseline(as_read);
  say(fmt::format("{} rows: listing what they could show", observed.num_rows()));
  std::vector<Candidate> candidates = AllCandidates(observed);
  say(fmt::format("weighing {} candidates", candidates.size()));
  SearchResult search = Search(observed, candidates, options.search);
  const Observed moved =
      AtBaseline(as_read, NuisancesOfAll(observed, candidates, search.found));
  if (!search.found.empty() && AreApart(observed, moved)) {
    say("the baseline lies elsewhere beside what was found: weighing again");
    observed = moved;
    const SearchOptions again = Again(options.search, candidates, search);
    candidates = AllCandidates(observed);
    search = Search(observed, candidates, again);
  }
  WeighWhereFound(observed, options.search, &candidates, &search);
  say("refining what was found");
  const std::string remark = Scrutinise(observed, candidates, &search);
  std::erase_if(search.found, [&](const Found& found) {
    return UmFromMm(Peak_mm(found.variant.columns_mm * found.sizes_mm)) <
           options.min_effect_um;
  });
  Diagnosis diagnosis = Reporter(observed, candidates, search).Make();
  if (!remark.empty()) diagnosis.remarks.push_back(remark);
  if (static_cast<int>(search.found.size()) >= options.search.most_findings) {
    diagnosis.remarks.push_back(fmt::format(
        "the search stops at {} findings: there may be more. Extend the machine with "
        "these (--extend) and diagnose the same rows again",
        options.search.most_findings));
  }
  for (const Finding& finding : diagnosis.findings) {
    const std::string jump = RemarkOnJump(observed.machine(), finding);
    if (!jump.empty()) diagnosis.remarks.push_back(jump);
  }
  const std::string noise = RemarkOnStatedNoise(observed, search);
  if (!noise.empty()) diagnosis.remarks.push_back(noise);
  diagnosis.min_effect_um = options.min_effect_um;
  diagnosis.facts = facts;
  diagnosis.is_extended = !as_read.effects().empty();
  LeaveOpen(facts, &diagnosis.baseline);
  NameByFacts(&diagnosis);
  DoubtNone(RemainsOf(observed, search), &diagnosis);
  NameTheLead(&diagnosis);
  return diagnosis;
}

}  // namespace caltwin
