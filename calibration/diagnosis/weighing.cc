#include "calibration/diagnosis/weighing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/dense.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Sizes that an effect may have, all equally likely beforehand.
constexpr std::array kScales_um = {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};
// Rates of wander asked for; none is as likely as all others together.
constexpr std::array kWanders_um_per_sqrt_h = {0.0, 0.5, 1.5, 5.0, 15.0};
constexpr double kSecondsPerHour = 3600;
// Wanders less likely than this against the best are not carried on.
constexpr double kNegligible_nats = 4;
constexpr std::size_t kVariantsInFull = 3;
constexpr int kDraws = 100;  // Of noise alone.
constexpr double kHopeless_nats = 12;

double WanderOf(double um_per_sqrt_h) {
  return std::pow(MmFromUm(um_per_sqrt_h), 2) / kSecondsPerHour;
}

// One noise, with its weight before the rows are asked and its likelihood.
struct NoiseWorld {
  double wander_mm2_per_s = 0;
  Evidence evidence;
  double log_none = 0;
  double noise_scale = 1;  ///< sqrt(chi2 / dof), at most 1: sigma's common factor.
};

std::vector<NoiseWorld> WorldsOf(const Observed& observed,
                                 const Circumstances& circumstances) {
  std::vector<NoiseWorld> worlds;
  for (const double rate : kWanders_um_per_sqrt_h) {
    if (rate > 0 && !observed.has_times()) break;
    Evidence evidence(observed,
                      {circumstances.sigma_mm, WanderOf(rate)},
                      circumstances.nuisances,
                      circumstances.left_out);
    const double prior =
        rate == 0 ? 0.5 : 0.5 / static_cast<double>(kWanders_um_per_sqrt_h.size() - 1);
    const double log_none = evidence.log_none() + std::log(prior);
    // Not more than the rows' own: what a cause adds to "nothing there" is no noise,
    // and would hold sizes as much nearer to 0.
    const double left = std::sqrt(evidence.chi2() / evidence.dof());
    const double noise_scale = std::min(1.0, left);
    worlds.push_back({WanderOf(rate), std::move(evidence), log_none, noise_scale});
  }
  return worlds;
}

// The still world always; of the others those that are likely.
void DropUnlikely(std::vector<NoiseWorld>* worlds) {
  double best = -std::numeric_limits<double>::infinity();
  for (const NoiseWorld& world : *worlds) best = std::max(best, world.log_none);
  std::erase_if(*worlds, [&](const NoiseWorld& world) {
    return world.wander_mm2_per_s > 0 && world.log_none < best - kNegligible_nats;
  });
}

// How likely each size is beforehand: all within a decade of the usual one about
// alike, far from it ever less. log of weights that sum to 1.
std::vector<double> LogWeights(double usual_mm) {
  std::vector<double> logs;
  for (const double scale_um : kScales_um) {
    const double decades = std::log10(MmFromUm(scale_um) / usual_mm);
    logs.push_back(-0.5 * std::pow(std::max(0.0, std::abs(decades) - 0.5) / 0.4, 2));
  }
  const double total = LogSum(logs);
  for (double& value : logs) value -= total;
  return logs;
}

// Averaged over the sizes; tells the best of them.
double LogBayesOverScales(const Evidence& evidence,
                          const Projected& projected,
                          const Eigen::VectorXd& relative,
                          double usual_mm,
                          double noise_scale,
                          double* best_scale_mm) {
  std::vector<double> logs = LogWeights(usual_mm);
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < kScales_um.size(); ++s) {
    const double scale_mm = MmFromUm(kScales_um[s]);
    const double in_sigma = scale_mm / noise_scale;
    const double log_bayes =
        logs[s] + evidence.LogBayes(projected, relative * (in_sigma * in_sigma));
    logs[s] = log_bayes;
    if (log_bayes > best) {
      best = log_bayes;
      *best_scale_mm = scale_mm;
    }
  }
  return LogSum(logs);
}

Eigen::VectorXd PriorOf(const Candidate& candidate, const Variant& variant) {
  if (candidate.is_free()) return candidate.free_prior;
  return Eigen::VectorXd::Ones(variant.columns_mm.cols());
}

// A size that may only be positive: twice the posterior's part above zero.
double LogPositive(const Projected& projected,
                   const Eigen::VectorXd& prior_in_sigma,
                   double noise_scale) {
  Eigen::MatrixXd inner = projected.gram;
  inner.diagonal() += prior_in_sigma.cwiseInverse();
  const Cholesky cholesky(inner);
  const Eigen::VectorXd mean = cholesky.Solve(projected.match);
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(mean.size());
  unit[0] = 1;
  const double sd = std::sqrt(cholesky.Solve(unit)[0]) * noise_scale;
  const double z = mean[0] / std::max(sd, 1e-300);
  const double part = 0.5 * std::erfc(-z / std::numbers::sqrt2);
  return std::log(2 * std::max(part, 1e-30));
}

struct Scored {
  std::size_t variant = 0;
  double log_prior = 0;  ///< Of its forms, among the candidate's.
  double log_bayes = -1e300;

  double log_likely() const { return log_prior + log_bayes; }
};

// Of its variants: log of weights that sum to 1.
std::vector<double> LogPriorsOf(const Candidate& candidate) {
  double total = 0;
  for (const Variant& variant : candidate.variants) total += variant.weight;
  std::vector<double> logs;
  for (const Variant& variant : candidate.variants)
    logs.push_back(std::log(variant.weight / total));
  return logs;
}

// What every variant shows, without freedom of form.
std::vector<Projected> ProjectedVariants(const Evidence& evidence,
                                         const Candidate& candidate) {
  std::vector<const Eigen::MatrixXd*> sets;
  for (const Variant& variant : candidate.variants) sets.push_back(&variant.columns_mm);
  return evidence.ProjectEach(sets);
}

std::vector<Scored> PlainScores(const NoiseWorld& world, const Candidate& candidate) {
  const std::vector<Projected> all = ProjectedVariants(world.evidence, candidate);
  const std::vector<double> log_priors = LogPriorsOf(candidate);
  std::vector<Scored> scores;
  for (std::size_t v = 0; v < candidate.variants.size(); ++v) {
    const Variant& variant = candidate.variants[v];
    double scale_mm = 0;
    scores.push_back({v,
                      log_priors[v],
                      LogBayesOverScales(world.evidence,
                                         all[v],
                                         PriorOf(candidate, variant),
                                         variant.usual_mm,
                                         world.noise_scale,
                                         &scale_mm)});
  }
  return scores;
}

struct InFull {
  double log_bayes = -1e300;
  double scale_mm = 0;
  Eigen::VectorXd sizes_mm{};
  Eigen::VectorXd deviation_mm{};
};

InFull WithFreedom(const NoiseWorld& world,
                   const Candidate& candidate,
                   const Variant& variant,
                   const Tolerance& tolerance,
                   double plain) {
  const Eigen::Index k = variant.columns_mm.cols(), m = tolerance.columns_mm.cols();
  Eigen::MatrixXd columns(variant.columns_mm.rows(), k + m);
  columns << variant.columns_mm, tolerance.columns_mm;
  Eigen::VectorXd relative(k + m);
  relative << PriorOf(candidate, variant), tolerance.prior;
  const Projected projected = world.evidence.Project(world.evidence.Whiten(columns));
  InFull full;
  full.log_bayes = LogBayesOverScales(world.evidence,
                                      projected,
                                      relative,
                                      variant.usual_mm,
                                      world.noise_scale,
                                      &full.scale_mm);
  const double in_sigma = full.scale_mm / world.noise_scale;
  const Eigen::VectorXd prior = relative * (in_sigma * in_sigma);
  Eigen::MatrixXd inner = projected.gram;
  inner.diagonal() += prior.cwiseInverse();
  const Eigen::VectorXd mean = Cholesky(inner).Solve(projected.match);
  full.sizes_mm = mean.head(k);
  if (m > 0) {
    // As likely beforehand: it has its textbook shape and no freedom is spent.
    full.log_bayes = LogSum({full.log_bayes, plain}) - std::numbers::ln2;
  }
  if (candidate.must_be_positive) {
    full.log_bayes += LogPositive(projected, prior, world.noise_scale);
  }
  full.deviation_mm = tolerance.columns_mm * mean.tail(m);
  return full;
}

// One variant in full; remembers it where it is the best so far.
double Refine(const NoiseWorld& world,
              const Candidate& candidate,
              const Scored& plain,
              Tolerances* tolerances,
              double* best,
              Weighed* weighed) {
  const InFull full = WithFreedom(world,
                                  candidate,
                                  candidate.variants[plain.variant],
                                  tolerances->Of(weighed->candidate, plain.variant),
                                  plain.log_bayes);
  const double log_likely = full.log_bayes + plain.log_prior + world.log_none;
  if (log_likely > *best) {
    *best = log_likely;
    weighed->variant = plain.variant;
    weighed->scale_mm = full.scale_mm;
    weighed->sizes_mm = full.sizes_mm;
    weighed->deviation_mm = full.deviation_mm;
  }
  return full.log_bayes;
}

// A candidate in all worlds: log of the sum over worlds of likelihood.
Weighed WeighOne(const std::vector<NoiseWorld>& worlds,
                 double log_none,
                 const Candidate& candidate,
                 std::size_t index,
                 Tolerances* tolerances) {
  Weighed weighed{.candidate = index};
  std::vector<double> logs;
  double best = -std::numeric_limits<double>::infinity();
  for (const NoiseWorld& world : worlds) {
    std::vector<Scored> scores = PlainScores(world, candidate);
    std::ranges::sort(scores, std::ranges::greater{}, &Scored::log_likely);
    const double likeliest = scores[0].log_likely();
    std::vector<double> of_variants;
    for (std::size_t s = 0; s < scores.size(); ++s) {
      const bool is_close = scores[s].log_likely() > likeliest - kHopeless_nats;
      if (s < kVariantsInFull && is_close) {
        scores[s].log_bayes =
            Refine(world, candidate, scores[s], tolerances, &best, &weighed);
      }
      of_variants.push_back(scores[s].log_likely());
    }
    logs.push_back(LogSum(of_variants) + world.log_none);
  }
  weighed.log_odds = LogSum(logs) - log_none + candidate.log_prior;
  return weighed;
}

// Among all candidates and none.
void ShareProbability(double log_odds_any, Weighing* weighing) {
  weighing->log_odds_any = log_odds_any;
  const double total = LogSum({log_odds_any, 0.0});
  for (Weighed& weighed : weighing->ranked) {
    weighed.probability = std::exp(weighed.log_odds - total);
  }
}

// What every draw says of one variant, added to its list.
void AddDraws(const Evidence& evidence,
              const Eigen::MatrixXd& readings,
              const Candidate& candidate,
              const Variant& variant,
              double log_prior,
              std::vector<std::vector<double>>* logs) {
  const Eigen::MatrixXd white = evidence.Whiten(variant.columns_mm);
  Projected projected = evidence.Project(white);
  const Eigen::MatrixXd matches = white.transpose() * readings;
  const Eigen::VectorXd relative = PriorOf(candidate, variant);
  const std::vector<double> weights = LogWeights(variant.usual_mm);
  for (Eigen::Index d = 0; d < readings.cols(); ++d) {
    projected.match = matches.col(d);
    const double chi2 = readings.col(d).squaredNorm();
    for (std::size_t s = 0; s < kScales_um.size(); ++s) {
      const double size_mm = MmFromUm(kScales_um[s]);
      (*logs)[static_cast<std::size_t>(d)].push_back(
          log_prior + weights[s] +
          LogBayesOf(projected, relative * size_mm * size_mm, chi2, evidence.dof()));
    }
  }
}

// How often a draw reaches `value`: counted, beyond the upper tenth as an exponential
// tail whose scale is that tenth's mean excess.
double ChanceBeyond(double value, std::vector<double> draws) {
  std::ranges::sort(draws, std::ranges::greater{});
  const std::size_t tail = std::max<std::size_t>(5, draws.size() / 10);
  const auto num = static_cast<double>(draws.size());
  if (value <= draws[tail]) {
    const auto above =
        std::ranges::count_if(draws, [&](double drawn) { return drawn >= value; });
    return static_cast<double>(above) / num;
  }
  double excess = 0;
  for (std::size_t i = 0; i < tail; ++i) excess += draws[i] - draws[tail];
  const double scale = std::max(excess / static_cast<double>(tail), 0.1);
  return static_cast<double>(tail) / num * std::exp(-(value - draws[tail]) / scale);
}

}  // namespace

double LogSum(const std::vector<double>& logs) {
  const double most = *std::ranges::max_element(logs);
  double sum = 0;
  for (const double value : logs) sum += std::exp(value - most);
  return most + std::log(sum);
}

double LikeliestScale_mm(const Evidence& evidence,
                         const Candidate& candidate,
                         const Variant& variant) {
  double scale_mm = 0;
  LogBayesOverScales(evidence,
                     evidence.Project(evidence.Whiten(variant.columns_mm)),
                     PriorOf(candidate, variant),
                     variant.usual_mm,
                     std::sqrt(evidence.chi2() / evidence.dof()),
                     &scale_mm);
  return scale_mm;
}

double MostWander_mm2_per_s() {
  return WanderOf(kWanders_um_per_sqrt_h.back());
}

void DropLikeliest(Weighing* weighing) {
  weighing->ranked.erase(weighing->ranked.begin());
  std::vector<double> logs = {-1e300};
  for (const Weighed& weighed : weighing->ranked) logs.push_back(weighed.log_odds);
  ShareProbability(LogSum(logs), weighing);
}

const Tolerance& Tolerances::Of(std::size_t candidate, std::size_t variant) {
  const auto [at, is_new] = made_.try_emplace({candidate, variant});
  if (is_new) {
    const Candidate& of = candidates_[candidate];
    at->second = ToleranceOf(observed_, of, of.variants[variant]);
  }
  return at->second;
}

Weighing Weigh(const Observed& observed,
               const std::vector<Candidate>& candidates,
               const Circumstances& circumstances,
               Tolerances* tolerances) {
  Tolerances own(observed, candidates);
  if (tolerances == nullptr) tolerances = &own;
  std::vector<NoiseWorld> worlds = WorldsOf(observed, circumstances);
  std::vector<double> none;
  for (const NoiseWorld& world : worlds) none.push_back(world.log_none);
  const double log_none = LogSum(none);
  Weighing weighing;
  weighing.wander_mm2_per_s =
      std::ranges::max_element(worlds, {}, &NoiseWorld::log_none)->wander_mm2_per_s;
  DropUnlikely(&worlds);
  std::vector<double> all;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    weighing.ranked.push_back(WeighOne(worlds, log_none, candidates[i], i, tolerances));
    all.push_back(weighing.ranked.back().log_odds);
  }
  if (all.empty()) return weighing;
  ShareProbability(LogSum(all), &weighing);
  std::ranges::stable_sort(weighing.ranked, std::ranges::greater{}, &Weighed::log_odds);
  return weighing;
}

double ChanceUnderNone(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       const Circumstances& circumstances,
                       double wander_mm2_per_s,
                       double log_odds_any,
                       std::uint64_t seed) {
  const Evidence evidence(observed,
                          {circumstances.sigma_mm, wander_mm2_per_s},
                          circumstances.nuisances,
                          circumstances.left_out);
  Rng rng(seed, 0, "diagnosis.bootstrap");
  Eigen::MatrixXd readings(observed.num_rows(), kDraws);
  for (double& value : readings.reshaped()) value = rng.Normal();
  readings = evidence.ProjectedReadings(readings);
  std::vector<std::vector<double>> logs(kDraws);
  for (const Candidate& candidate : candidates) {
    const std::vector<double> log_priors = LogPriorsOf(candidate);
    for (std::size_t v = 0; v < log_priors.size(); ++v) {
      AddDraws(evidence,
               readings,
               candidate,
               candidate.variants[v],
               candidate.log_prior + log_priors[v],
               &logs);
    }
  }
  std::vector<double> any;
  for (const auto& of_draw : logs) any.push_back(LogSum(of_draw));
  return ChanceBeyond(log_odds_any, std::move(any));
}

}  // namespace caltwin
