#include "calibration/diagnosis/next_campaign.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "calibration/diagnosis/atlas.h"
#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/free_form.h"
#include "calibration/diagnosis/stories.h"
#include "sim/base/dense.h"
#include "sim/base/input_error.h"
#include "sim/base/median.h"

namespace caltwin {
namespace {

constexpr double kPause_s = 600;
constexpr double kSecondsPerMinute = 60;
constexpr double kApart_sigma = 3;
constexpr double kResolved_sigma = 5;
// Real shapes differ from their formulas by a fifth: what is apart by less in formulas
// may still be one in rows.
constexpr double kEnough_sigma = 30;
constexpr double kLeastGain_sigma = 0.025;  // Weighted: 0.5 of the least likely.
constexpr double kAmbiguousAbove = 0.05;
constexpr int kMostTerms = 12;

double LastTime_s(const Observed& observed) {
  double last_s = 0;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (Known(observed.row(i).t_s)) last_s = std::max(last_s, observed.row(i).t_s);
  }
  return last_s;
}

// Sigmas as judged; of planned readings as stated, else as those of the same kind.
Eigen::VectorXd SigmaOf(const Observed& both, const Eigen::VectorXd& judged_mm) {
  Eigen::VectorXd sigma_mm = PlannedSigma_mm(both);
  const Eigen::Index n = judged_mm.size();
  sigma_mm.head(n) = judged_mm;
  for (const RowKind kind : {RowKind::kPosition, RowKind::kTouch, RowKind::kRadial}) {
    std::vector<double> known;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (both.at(i).kind == kind) known.push_back(judged_mm[i]);
    }
    if (known.empty()) continue;
    const double usual_mm = Median(known);
    for (Eigen::Index i = n; i < both.num_rows(); ++i) {
      if (both.at(i).kind == kind) sigma_mm[i] = usual_mm;
    }
  }
  return sigma_mm;
}

struct Rated {
  NextCampaign next{};
  double rate = 0;
  bool resolves = false;
  bool is_of_use = false;  ///< It separates what the rows at hand do not.
};

// One finding against one campaign more.
class Rater {
 public:
  Rater(const Observed& observed,
        const std::vector<Candidate>& candidates,
        const SearchResult& search,
        const Found& found,
        std::vector<std::size_t> rivals)
      : observed_(observed),
        candidates_(candidates),
        search_(search),
        found_(found),
        rivals_(std::move(rivals)) {
    if (!rivals_.empty()) now_sigma_ = SeparationsIn(observed);
  }

  Rated Rate(const CampaignChoice& choice, std::uint64_t seed) const {
    const Plan plan{.instruments = observed_.header().instruments,
                    .campaigns = {choice.campaign}};
    PlannedSession session = PlanSession(plan, observed_.machine(), seed);
    const double minutes = session.duration_s / kSecondsPerMinute;
    const Observed both = Followed(observed_, std::move(session));
    Rated rated{.next = {.kind = choice.campaign.id, .minutes = minutes}};
    for (const auto& [option, word] : choice.changed) {
      rated.next.options[option] = word;
    }
    if (rivals_.empty()) {
      rated.rate = InformationGained(both, EvidenceOf(both)) / minutes;
      rated.next.separates = {"unknown"};
      rated.resolves = rated.is_of_use = true;
      return rated;
    }
    const std::vector<double> then_sigma = SeparationsIn(both);
    double gained_sigma = 0, least_sigma = INFINITY;
    rated.next.separates = {candidates_[found_.candidate].cause};
    for (std::size_t r = 0; r < rivals_.size(); ++r) {
      // What the rows at hand do already is no merit of the campaign.
      gained_sigma += Weight(rivals_[r]) * (std::min(then_sigma[r], kEnough_sigma) -
                                            std::min(now_sigma_[r], kEnough_sigma));
      least_sigma = std::min(least_sigma, then_sigma[r]);
      const std::string& cause = candidates_[rivals_[r]].cause;
      auto& names = rated.next.separates;
      if (then_sigma[r] >= kApart_sigma &&
          std::ranges::find(names, cause) == names.end()) {
        names.push_back(cause);
      }
    }
    rated.next.separation_sigma = least_sigma;
    rated.rate = gained_sigma / minutes;
    rated.is_of_use =
        gained_sigma > kLeastGain_sigma && rated.next.separates.size() > 1;
    rated.resolves = least_sigma >= kResolved_sigma;
    return rated;
  }

 private:
  Evidence EvidenceOf(const Observed& both) const {
    std::vector<bool> left_out = search_.circumstances.left_out;
    left_out.resize(static_cast<std::size_t>(both.num_rows()), false);
    std::vector<Nuisance> baseline = BaselineOf(both);
    for (const Found& other : search_.found) {
      if (&other != &found_) AddOther(both, other, &baseline);
    }
    return {both,
            {SigmaOf(both, search_.circumstances.sigma_mm), search_.wander_mm2_per_s},
            baseline,
            left_out};
  }

  // What else was found is there as well, and its sizes are open.
  void AddOther(const Observed& both,
                const Found& other,
                std::vector<Nuisance>* baseline) const {
    constexpr double kFree = 30;  // Times what was found.
    const Candidate& candidate = candidates_[other.candidate];
    const double size_mm = std::max(other.scale_mm, other.sizes_mm.norm());
    if (candidate.is_free()) {
      const FreeForm form = FreeFormOf(
          both, candidate.shown.channel, candidate.shown.covariates, kMostTerms);
      for (Eigen::Index k = 0; k < form.columns_mm.cols(); ++k) {
        baseline->push_back({.column_mm = form.columns_mm.col(k),
                             .prior_sd = size_mm * std::sqrt(form.prior[k]),
                             .reported = false});
      }
      return;
    }
    const Variant its =
        VariantOf(both, candidate.effect, candidate.axis, other.variant.forms);
    for (Eigen::Index k = 0; k < its.columns_mm.cols(); ++k) {
      baseline->push_back({.column_mm = its.columns_mm.col(k),
                           .prior_sd = kFree * size_mm,
                           .reported = false});
    }
  }

  // What becomes known of the shape, and of the causes that could hide in it (waves
  // between the positions): 1/2 log|I + D A|.
  double InformationGained(const Observed& both, const Evidence& evidence) const {
    const Candidate& own = candidates_[found_.candidate];
    const FreeForm form =
        FreeFormOf(both, own.shown.channel, own.shown.covariates, kMostTerms);
    if (form.columns_mm.cols() == 0) return 0;
    const double size_mm = std::max(found_.scale_mm, found_.sizes_mm.norm());
    Eigen::MatrixXd columns_mm = form.columns_mm;
    Eigen::VectorXd sd = form.prior.cwiseSqrt() * size_mm;
    for (const Candidate& other : candidates_) {
      if (other.is_free() || !ShareRowsAndVariable(own.shown, other.shown)) continue;
      const Variant its =
          VariantOf(both, other.effect, other.axis, other.variants[0].forms);
      const Eigen::Index more = its.columns_mm.cols();
      if (more == 0) continue;
      columns_mm.conservativeResize(Eigen::NoChange, columns_mm.cols() + more);
      columns_mm.rightCols(more) = its.columns_mm;
      sd.conservativeResize(columns_mm.cols());
      sd.tail(more).setConstant(its.usual_mm);
    }
    Eigen::MatrixXd inner = sd.asDiagonal() *
                            evidence.Project(evidence.Whiten(columns_mm)).gram *
                            sd.asDiagonal();
    inner.diagonal().array() += 1;
    return Cholesky(inner).diagonal().array().log().sum();
  }

  // The likelier a rival, the more it is worth to be rid of it.
  double Weight(std::size_t rival) const {
    constexpr double kLeast = 0.05;
    const auto known = std::ranges::find(found_.rivals, rival, &Rival::candidate);
    return std::max(kLeast, known == found_.rivals.end() ? 0 : known->probability);
  }

  // How far each rival is from the finding in these rows.
  std::vector<double> SeparationsIn(const Observed& both) const {
    const Candidate& own = candidates_[found_.candidate];
    std::vector<double> sigmas(rivals_.size(), 0);
    const Variant mine = VariantOf(both, own.effect, own.axis, found_.variant.forms);
    if (mine.columns_mm.cols() != found_.sizes_mm.size()) return sigmas;
    const Evidence evidence = EvidenceOf(both);
    const Eigen::VectorXd effect =
        evidence.Whiten(mine.columns_mm * found_.sizes_mm *
                        (found_.variant.size_per_mm / mine.size_per_mm));
    const Eigen::MatrixXd whole = evidence.Project(effect).gram;
    for (std::size_t r = 0; r < rivals_.size(); ++r) {
      const double lambda =
          LambdaTo(both, evidence, effect, whole, candidates_[rivals_[r]]);
      sigmas[r] = std::sqrt(std::max(lambda, 0.0));
    }
    return sigmas;
  }

  static double LambdaTo(const Observed& both,
                         const Evidence& evidence,
                         const Eigen::VectorXd& effect,
                         const Eigen::MatrixXd& whole,
                         const Candidate& rival) {
    double least = whole(0, 0);
    for (const Variant& variant : rival.variants) {
      const Variant its = VariantOf(both, rival.effect, rival.axis, variant.forms);
      if (its.columns_mm.cols() == 0) continue;
      const Eigen::MatrixXd white = evidence.Whiten(its.columns_mm);
      const Eigen::MatrixXd cross = white.transpose() * evidence.Left(effect);
      if (rival.must_be_positive && cross.rows() == 1 && cross(0, 0) < 0) continue;
      least = std::min(
          least,
          Lambda(whole, cross, evidence.Project(white).gram, 1, /*is_random=*/false));
    }
    return least;
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const SearchResult& search_;
  const Found& found_;
  std::vector<std::size_t> rivals_;
  std::vector<double> now_sigma_{};  ///< Of each rival, in the rows at hand.
};

// Named rivals that keep a finding from being sure.
std::vector<std::size_t> RivalsOf(const std::vector<Candidate>& candidates,
                                  const Found& found) {
  std::vector<std::size_t> rivals;
  for (const Rival& rival : found.rivals) {
    const bool matters = rival.structural || rival.probability > kAmbiguousAbove;
    if (matters && !candidates[rival.candidate].is_free()) {
      rivals.push_back(rival.candidate);
    }
  }
  return rivals;
}

// The best of all campaigns for one finding; none where none would add to what is
// known.
std::optional<NextCampaign> BestFor(const Rater& rater, std::uint64_t seed) {
  std::optional<Rated> best;
  for (const CampaignChoice& choice : CampaignChoices()) {
    try {
      Rated rated = rater.Rate(choice, seed);
      if (!rated.is_of_use) continue;
      if (!best || std::pair(rated.resolves, rated.rate) >
                       std::pair(best->resolves, best->rate)) {
        best = std::move(rated);
      }
    } catch (const InputError&) {
      continue;  // It does not fit this machine's travel.
    }
  }
  if (!best) return std::nullopt;
  return best->next;
}

}  // namespace

Observed Followed(const Observed& observed, PlannedSession session) {
  RowTable table = observed.table();
  DataHeader header = observed.header();
  const double start_s = LastTime_s(observed) + kPause_s;
  for (Row row : session.rows) {
    row.row = static_cast<std::int64_t>(table.rows.size()) + 1;
    row.campaign = "next_" + row.campaign;
    if (row.kind == RowKind::kTouch || !row.setup.empty()) {
      row.setup = "next_" + (row.setup.empty() ? row.campaign : row.setup);
    }
    row.home = "next_" + row.home;
    row.t_s = observed.has_times() ? row.t_s + start_s : kUnknown;
    row.extra.resize(table.extra_columns.size());
    table.rows.push_back(std::move(row));
  }
  header.instruments.merge(session.header.instruments);
  header.artefacts.merge(session.header.artefacts);
  for (const auto& [name, campaign] : session.header.campaigns) {
    header.campaigns["next_" + name] = campaign;
  }
  return {std::move(table), std::move(header), observed.machine(), observed.effects()};
}

std::optional<NextCampaign> BestNext(const Observed& observed,
                                     const std::vector<Candidate>& candidates,
                                     const SearchResult& search,
                                     std::uint64_t seed) {
  for (const Found& found : search.found) {
    const bool is_free = candidates[found.candidate].is_free();
    const auto rivals = RivalsOf(candidates, found);
    if (is_free || rivals.empty()) continue;
    if (auto best = BestFor({observed, candidates, search, found, rivals}, seed)) {
      return best;
    }
  }
  for (const Found& found : search.found) {
    if (!candidates[found.candidate].is_free()) continue;
    return BestFor({observed, candidates, search, found, {}}, seed);
  }
  return std::nullopt;
}

}  // namespace caltwin
