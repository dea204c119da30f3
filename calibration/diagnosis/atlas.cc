#include "calibration/diagnosis/atlas.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/evidence.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSeen_sigma = 5;
constexpr double kLeastShare = 0.02;
constexpr double kFarBeyondUsual = 10;
constexpr double kApart_sigma = 3;
constexpr double kUnsaidSigma_mm = 1e-3;
constexpr double kNever_um = 1e9;
// A baseline line is named where it takes this much of what the largest takes.
constexpr double kNotable = 0.25;
constexpr std::size_t kMostLines = 3;

// What |M W Phi a|^2 is at least for sizes a of rms 1: in the worst phase; where every
// column has a size of its own (each homing), on average.
double LeastPower(const Eigen::MatrixXd& gram, bool is_random) {
  if (is_random || gram.cols() == 1) return std::max(gram.trace(), 0.0);
  return std::max(EigenvaluesOf(gram)[0], 0.0);
}

bool IsRandom(const Candidate& candidate) {
  return candidate.variants.front().columns_mm.cols() > 2;
}

// Which lines of the baseline imitate a column, and how much each takes.
class Imitation {
 public:
  Imitation(const Evidence& evidence, const std::vector<Nuisance>& baseline)
      : baseline_(baseline) {
    const auto q = static_cast<Eigen::Index>(baseline.size());
    const Eigen::Index n = evidence.white_residual().size();
    white_.resize(n, q);
    for (Eigen::Index k = 0; k < q; ++k) {
      const Nuisance& line = baseline[static_cast<std::size_t>(k)];
      white_.col(k) = evidence.Whiten(line.column_mm) * line.prior_sd;
    }
    Eigen::MatrixXd tall(n + q, q);
    tall.topRows(n) = white_;
    tall.bottomRows(q).setIdentity();
    qr_ = QrOf(tall);
  }

  std::string Into(const Eigen::VectorXd& white) const {
    const Eigen::Index q = white_.cols();
    Eigen::VectorXd target = Eigen::VectorXd::Zero(white.size() + q);
    target.head(white.size()) = white;
    const Eigen::VectorXd taken =
        white_.colwise().norm().transpose().cwiseProduct(qr_.Solve(target).cwiseAbs());
    std::vector<Eigen::Index> order(static_cast<std::size_t>(q));
    for (std::size_t k = 0; k < order.size(); ++k) {
      order[k] = static_cast<Eigen::Index>(k);
    }
    std::ranges::stable_sort(
        order, std::ranges::greater{}, [&](Eigen::Index k) { return taken[k]; });
    std::vector<std::string> names;
    for (const Eigen::Index k : order) {
      if (names.size() == kMostLines || taken[k] < kNotable * taken[order[0]]) break;
      names.push_back(baseline_[static_cast<std::size_t>(k)].name);
    }
    return fmt::format("{}", fmt::join(names, ", "));
  }

 private:
  const std::vector<Nuisance>& baseline_;
  Eigen::MatrixXd white_{};  ///< In units of each line's prior.
  QrOf qr_{};
};

// One candidate under one noise: the variant that stands for all, and how it is seen.
struct Sighted {
  const Candidate* candidate = nullptr;
  std::size_t typical = 0;
  AtlasCause line{};
};

double Smallest_um(const Eigen::MatrixXd& gram, bool is_random) {
  const double power = LeastPower(gram, is_random);
  return power > 0 ? std::min(UmFromMm(kSeen_sigma / std::sqrt(power)), kNever_um)
                   : kNever_um;
}

Sighted SightOf(const Evidence& evidence, const Candidate& candidate) {
  const bool is_random = IsRandom(candidate);
  std::vector<std::pair<double, std::size_t>> by_size;
  for (std::size_t v = 0; v < candidate.variants.size(); ++v) {
    const Eigen::MatrixXd white = evidence.Whiten(candidate.variants[v].columns_mm);
    by_size.emplace_back(Smallest_um(evidence.Project(white).gram, is_random), v);
  }
  // A wave must be seen whatever its period; of other forms the middle one stands for
  // all: a jump in the very last row is seen by nobody.
  const bool is_wave = candidate.variants.front().columns_mm.cols() == 2;
  const auto middle =
      by_size.begin() + static_cast<std::ptrdiff_t>(is_wave ? by_size.size() - 1
                                                            : (by_size.size() - 1) / 2);
  std::ranges::nth_element(by_size, middle);
  const Variant& variant = candidate.variants[middle->second];
  const Eigen::MatrixXd white = evidence.Whiten(variant.columns_mm);
  const double left = LeastPower(evidence.Project(white).gram, is_random);
  const double whole = LeastPower(white.transpose() * white, is_random);
  return {.candidate = &candidate,
          .typical = middle->second,
          .line = {.cause = candidate.cause,
                   .axis = candidate.axis,
                   .smallest_um = middle->first,
                   .usual_um = UmFromMm(variant.usual_mm),
                   .share_left = whole > 0 ? std::sqrt(left / whole) : 0}};
}

bool IsAbsorbed(const AtlasCause& line) {
  return line.share_left < kLeastShare ||
         line.smallest_um > kFarBeyondUsual * line.usual_um;
}

// The phase in which least is left.
Eigen::VectorXd WorstOf(const Evidence& evidence, const Sighted& sighted) {
  const Eigen::MatrixXd white =
      evidence.Whiten(sighted.candidate->variants[sighted.typical].columns_mm);
  if (white.cols() == 1) return white;
  return white * ModesOf(evidence.Project(white).gram).vectors.col(0);
}

std::vector<AtlasCause> UnseenOf(const std::vector<Candidate>& candidates,
                                 const MachineKind* kind) {
  std::vector<AtlasCause> unseen;
  for (int index = 0; index < static_cast<int>(kNumEffects); ++index) {
    const Effect& effect = EffectAt(index);
    const auto axes = AxesOn(effect, kind);
    if (!effect.sight || axes.empty() || axes[0] == kAnyAxis) continue;
    for (const std::string_view axis : axes) {
      const bool is_seen = std::ranges::any_of(candidates, [&](const Candidate& one) {
        return one.effect == index && one.axis == axis;
      });
      if (!is_seen) {
        unseen.push_back(
            {.cause = std::string(effect.name), .axis = std::string(axis)});
      }
    }
  }
  return unseen;
}

// All columns of all variants in one table, so that every pair is two blocks of it.
class Pairs {
 public:
  Pairs(const Observed& observed,
        const Evidence& evidence,
        const std::vector<Sighted>& sighted)
      : sighted_(sighted) {
    Eigen::Index count = 0;
    for (const Sighted& one : sighted) {
      starts_.emplace_back();
      for (const Variant& variant : one.candidate->variants) {
        starts_.back().push_back(count);
        count += variant.columns_mm.cols();
      }
    }
    Eigen::MatrixXd columns_mm(observed.num_rows(), count);
    for (std::size_t i = 0; i < sighted.size(); ++i) {
      const auto& variants = sighted[i].candidate->variants;
      for (std::size_t v = 0; v < variants.size(); ++v) {
        columns_mm.middleCols(starts_[i][v], variants[v].columns_mm.cols()) =
            variants[v].columns_mm;
      }
    }
    gram_ = evidence.Project(evidence.Whiten(columns_mm)).gram;
  }

  std::vector<ConfoundedPair> Confounded() const {
    std::vector<ConfoundedPair> pairs;
    for (std::size_t i = 0; i < sighted_.size(); ++i) {
      for (std::size_t j = i + 1; j < sighted_.size(); ++j) {
        const double sigma = std::sqrt(std::min(Apart(i, j), Apart(j, i)));
        if (sigma >= kApart_sigma) continue;
        pairs.push_back({sighted_[i].line, sighted_[j].line, sigma});
      }
    }
    std::ranges::stable_sort(pairs, {}, &ConfoundedPair::separation_sigma);
    return pairs;
  }

 private:
  // How badly `rival` imitates what `own` typically does.
  double Apart(std::size_t own, std::size_t rival) const {
    const Candidate& a = *sighted_[own].candidate;
    const Candidate& b = *sighted_[rival].candidate;
    const auto at = starts_[own][sighted_[own].typical];
    const auto n = a.variants[sighted_[own].typical].columns_mm.cols();
    const Eigen::MatrixXd mine = gram_.block(at, at, n, n);
    const double size_mm =
        MmFromUm(std::max(sighted_[own].line.usual_um, sighted_[own].line.smallest_um));
    double least = LeastPower(mine, IsRandom(a)) * size_mm * size_mm;
    for (std::size_t v = 0; v < b.variants.size(); ++v) {
      const auto from = starts_[rival][v];
      const auto m = b.variants[v].columns_mm.cols();
      const Eigen::MatrixXd cross = gram_.block(from, at, m, n);
      const bool is_opposed = a.must_be_positive && b.must_be_positive && m == 1 &&
                              n == 1 && cross(0, 0) < 0;
      if (is_opposed) continue;
      least = std::min(
          least,
          Lambda(mine, cross, gram_.block(from, from, m, m), size_mm, IsRandom(a)));
    }
    return std::max(least, 0.0);
  }

  const std::vector<Sighted>& sighted_;
  std::vector<std::vector<Eigen::Index>> starts_{};
  Eigen::MatrixXd gram_{};
};

}  // namespace

std::string AtlasCause::Name() const {
  return axis.empty() ? cause : cause + "." + axis;
}

double Lambda(const Eigen::MatrixXd& own,
              const Eigen::MatrixXd& cross,
              const Eigen::MatrixXd& rival,
              double size_mm,
              bool is_random) {
  constexpr double kRounding = 1e-9;
  Eigen::MatrixXd inner = rival;
  inner.diagonal().array() += kRounding * (rival.diagonal().maxCoeff() + 1e-30);
  const Eigen::MatrixXd left =
      own - cross.transpose() * Cholesky(inner).SolveEach(cross);
  return LeastPower(left, is_random) * size_mm * size_mm;
}

Eigen::VectorXd PlannedSigma_mm(const Observed& observed) {
  Eigen::VectorXd sigma_mm(observed.num_rows());
  for (Eigen::Index i = 0; i < sigma_mm.size(); ++i) {
    const double stated_mm = observed.StatedSigma_mm(i);
    sigma_mm[i] = Known(stated_mm) ? stated_mm : kUnsaidSigma_mm;
  }
  return sigma_mm;
}

std::vector<AtlasCause> AbsorbedOf(const Observed& observed,
                                   const std::vector<Candidate>& candidates,
                                   const Eigen::VectorXd& sigma_mm,
                                   const std::vector<Nuisance>& baseline) {
  const Evidence evidence(observed, {sigma_mm, 0}, baseline);
  std::optional<Imitation> imitation;
  std::vector<AtlasCause> absorbed;
  for (const Candidate& candidate : candidates) {
    if (candidate.is_free()) continue;
    Sighted sighted = SightOf(evidence, candidate);
    if (!IsAbsorbed(sighted.line)) continue;
    if (!imitation) imitation.emplace(evidence, baseline);
    sighted.line.into = imitation->Into(WorstOf(evidence, sighted));
    absorbed.push_back(std::move(sighted.line));
  }
  return absorbed;
}

Atlas AtlasOf(const Observed& observed,
              const std::vector<Candidate>& candidates,
              const Eigen::VectorXd& sigma_mm) {
  const std::vector<Nuisance> baseline = BaselineOf(observed);
  Atlas atlas{.absorbed = AbsorbedOf(observed, candidates, sigma_mm, baseline),
              .unseen = UnseenOf(candidates, observed.machine().kind)};
  const Evidence evidence(observed, {sigma_mm, 0}, baseline);
  std::vector<Sighted> visible;
  for (const Candidate& candidate : candidates) {
    if (candidate.is_free()) continue;
    Sighted sighted = SightOf(evidence, candidate);
    if (IsAbsorbed(sighted.line)) continue;
    atlas.visible.push_back(sighted.line);
    visible.push_back(std::move(sighted));
  }
  if (!visible.empty()) {
    atlas.confounded = Pairs(observed, evidence, visible).Confounded();
  }
  return atlas;
}

}  // namespace caltwin
