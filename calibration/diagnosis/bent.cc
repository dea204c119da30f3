#include "calibration/diagnosis/bent.h"

#include <algorithm>
#include <cmath>

#include "sim/base/dense.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr int kRounds = 20;
constexpr int kHalvings = 8;
constexpr double kStep = 1e-4;     // Of a parameter's range, for its slope.
constexpr double kSettled = 0.01;  // Of a value's standard deviation.
constexpr double kFine = 0.1;      // Of the noise.

bool IsBending(const Candidate& candidate) {
  return candidate.effect == EffectIndex<PivotPosition>() ||
         candidate.effect == EffectIndex<MotorsSwapped>() ||
         candidate.effect == EffectIndex<OverconstrainedBed>() || IsRigid(candidate);
}

using Effects = std::vector<Injected>;

// A place to stand: all bent findings at some values.
struct Stand {
  Effects effects{};
  double chi2 = 0, dof = 0;
};

class Bender {
 public:
  Bender(const Observed& observed,
         const std::vector<Candidate>& candidates,
         const SearchResult& search)
      : observed_(observed), search_(search) {
    nuisances_ = search.circumstances.nuisances;
    for (std::size_t i = 0; i < search.found.size(); ++i) {
      const Candidate& candidate = candidates[search.found[i].candidate];
      if (IsBending(candidate) && !search.found[i].lost_its_name) {
        bending_.push_back(i);
        start_.push_back(
            NeutralEffect(candidate.effect, candidate.axis, observed.machine()));
        continue;
      }
      const auto more = NuisancesOf(observed, candidate, search.found[i]);
      nuisances_.insert(nuisances_.end(), more.begin(), more.end());
    }
  }

  std::vector<Bent> Fit() const {
    if (bending_.empty()) return {};
    Stand stand = StandAt(start_);
    Eigen::MatrixXd slopes = Slopes(stand.effects);
    Normal normal = NormalAt(stand, slopes);
    for (int round = 0; round < kRounds; ++round) {
      const Stand next = Downhill(stand, normal.step);
      const Eigen::VectorXd moved = Flat(next.effects) - Flat(stand.effects);
      const bool is_settled =
          (moved.array().abs() <= kSettled * normal.sds.array()).all();
      stand = next;
      slopes = Slopes(stand.effects);
      normal = NormalAt(stand, slopes);
      if (is_settled) break;
    }
    return BentAt(stand, slopes, normal.sds);
  }

 private:
  struct Normal {
    Eigen::VectorXd step{}, sds{};  ///< In the parameters' units.
  };

  Evidence EvidenceAt(const Observed& there) const {
    return {there,
            {search_.circumstances.sigma_mm, search_.wander_mm2_per_s},
            nuisances_,
            search_.circumstances.left_out};
  }

  Stand StandAt(Effects effects) const {
    const Observed there = observed_.With(effects);
    const Evidence evidence = EvidenceAt(there);
    return {std::move(effects), evidence.chi2(), evidence.dof()};
  }

  Normal NormalAt(const Stand& stand, const Eigen::MatrixXd& slopes) const {
    const Observed there = observed_.With(stand.effects);
    const Evidence evidence = EvidenceAt(there);
    Projected projected = evidence.Project(evidence.Whiten(slopes));
    // Of one size, whatever their units.
    const Eigen::VectorXd scale =
        projected.gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd gram = scale.asDiagonal() * projected.gram * scale.asDiagonal();
    gram.diagonal().array() += 1e-12;
    const Eigen::MatrixXd inverse = PivotedCholesky(gram).Inverse();
    const Eigen::MatrixXd covariance =
        scale.asDiagonal() * inverse * scale.asDiagonal();
    return {covariance * projected.match,
            (covariance.diagonal() * (stand.chi2 / stand.dof)).cwiseSqrt()};
  }

  // As far along the step as the rows are foretold better, or not at all.
  Stand Downhill(const Stand& from, const Eigen::VectorXd& step) const {
    double part = 1;
    for (int halving = 0; halving < kHalvings; ++halving, part /= 2) {
      Stand to = StandAt(Moved(from.effects, part * step));
      if (to.chi2 < from.chi2) return to;
    }
    return from;
  }

  static Effects Moved(Effects effects, const Eigen::VectorXd& by) {
    Eigen::Index at = 0;
    for (Injected& effect : effects) {
      const auto parameters = EffectAt(effect.effect).parameters;
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        effect.values[p] = std::clamp(
            effect.values[p] + by[at++], parameters[p].min, parameters[p].max);
      }
    }
    return effects;
  }

  static Eigen::VectorXd Flat(const Effects& effects) {
    std::vector<double> all;
    for (const Injected& effect : effects) {
      all.insert(all.end(), effect.values.begin(), effect.values.end());
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(),
                                       static_cast<Eigen::Index>(all.size()));
  }

  // What effects do together to each row.
  Eigen::VectorXd Change_mm(const Effects& effects) const {
    return observed_.residual_mm() - observed_.With(effects).residual_mm();
  }

  // By each parameter of each, all others in force [mm per its unit].
  Eigen::MatrixXd Slopes(const Effects& effects) const {
    Eigen::MatrixXd slopes(observed_.num_rows(), Flat(effects).size());
    Eigen::Index at = 0;
    for (std::size_t k = 0; k < effects.size(); ++k) {
      const auto parameters = EffectAt(effects[k].effect).parameters;
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double step = kStep * (parameters[p].max - parameters[p].min);
        Effects above = effects, below = effects;
        above[k].values[p] += step;
        below[k].values[p] -= step;
        slopes.col(at++) = (Change_mm(above) - Change_mm(below)) / (2 * step);
      }
    }
    return slopes;
  }

  std::vector<Bent> BentAt(const Stand& stand,
                           const Eigen::MatrixXd& slopes,
                           const Eigen::VectorXd& sds) const {
    std::vector<Bent> all;
    Effects upto;
    Eigen::VectorXd before_mm = Eigen::VectorXd::Zero(observed_.num_rows());
    Eigen::Index at = 0;
    for (std::size_t k = 0; k < stand.effects.size(); ++k) {
      const Injected& effect = stand.effects[k];
      upto.push_back(effect);
      const Eigen::VectorXd upto_mm = Change_mm(upto);
      const auto num = static_cast<Eigen::Index>(effect.values.size());
      const Eigen::VectorXd own_sds = sds.segment(at, num);
      all.push_back({bending_[k],
                     {.effect = effect,
                      .sds = {own_sds.begin(), own_sds.end()},
                      .variant = search_.found[bending_[k]].variant}});
      Place(slopes.middleCols(at, num), upto_mm - before_mm, &all.back().refined);
      before_mm = upto_mm;
      at += num;
    }
    return all;
  }

  // Columns at these slopes that add up to the change, a near-peak of 1 mm.
  static void Place(Eigen::MatrixXd columns,
                    const Eigen::VectorXd& change_mm,
                    Refined* refined) {
    const Eigen::VectorXd values = Flat({refined->effect});
    if (values.squaredNorm() > 0) {
      const Eigen::VectorXd bent_mm = change_mm - columns * values;
      columns += bent_mm * values.transpose() / values.squaredNorm();
    }
    const double peak_mm = Peak_mm(columns.rowwise().norm());
    if (peak_mm == 0) return;
    Variant& variant = refined->variant;
    variant.usual_mm *= variant.size_per_mm * peak_mm;
    variant.columns_mm = columns / peak_mm;
    variant.size_per_mm = 1 / peak_mm;
    refined->sizes_mm = values * peak_mm;
  }

  const Observed& observed_;
  const SearchResult& search_;
  std::vector<std::size_t> bending_{};
  Effects start_{};
  std::vector<Nuisance> nuisances_{};
};

}  // namespace

std::vector<Bent> Bend(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       const SearchResult& search) {
  return Bender(observed, candidates, search).Fit();
}

bool TakeWhereFound(const std::vector<Bent>& bent,
                    const SearchResult& search,
                    std::vector<Candidate>* candidates) {
  const double noise_mm = search.circumstances.sigma_mm.minCoeff();
  bool is_other = false;
  for (const Bent& one : bent) {
    const Variant& found = one.refined.variant;
    Variant& variant =
        (*candidates)[search.found[one.finding].candidate].variants.front();
    const Eigen::VectorXd values = one.refined.sizes_mm * found.size_per_mm;
    const Eigen::VectorXd was_mm = variant.columns_mm * values / variant.size_per_mm;
    const Eigen::VectorXd is_mm = found.columns_mm * one.refined.sizes_mm;
    is_other |= (is_mm - was_mm).cwiseAbs().maxCoeff() > kFine * noise_mm;
    variant = found;
  }
  return is_other;
}

}  // namespace caltwin
