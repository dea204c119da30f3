#include "calibration/diagnosis/gain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/rounding.h"

namespace caltwin {
namespace {

constexpr int kBlocks = 5;
constexpr int kMostPositionFolds = 40;
constexpr double kForetold = 1.5;  // Of a row's sigma that the baseline may leave open.

using Lines = std::vector<std::vector<Nuisance>>;  ///< By finding.

class Gainer {
 public:
  Gainer(const Observed& observed,
         const std::vector<Candidate>& candidates,
         const SearchResult& search,
         const std::vector<Refined>& refined,
         bool has_freedom)
      : observed_(observed), candidates_(candidates), search_(search) {
    for (std::size_t i = 0; i < search.found.size(); ++i) {
      Found found = search.found[i];
      if (refined[i].effect.effect >= 0) {
        found.variant = refined[i].variant;
        found.sizes_mm = refined[i].sizes_mm;
      }
      more_.push_back(NuisancesOf(observed, candidates[found.candidate], found));
      const auto sizes = static_cast<std::size_t>(found.variant.columns_mm.cols());
      if (!has_freedom) more_.back().resize(sizes);
    }
  }

  // Rows of one group are left out together; group -1 is always fitted, never scored.
  // With `chooses_sizes` the prior sizes of tables are chosen without those rows, too.
  HeldOut LeaveOut(const std::vector<int>& group_of, bool chooses_sizes = false) const {
    HeldOut held;
    held.groups = 1 + *std::ranges::max_element(group_of);
    if (held.groups < 2) return {};
    const std::vector<bool>& out = search_.circumstances.left_out;
    const Evidence::Foretold without =
        EvidenceOf(NoFinding(), out, more_).Foretell(group_of);
    const Eigen::VectorXd with =
        more_.empty() ? without.residual_mm
        : chooses_sizes && HasFreeForm()
            ? ResidualsChosenAnew(group_of, held.groups)
            : EvidenceOf(All(), out, more_).Foretell(group_of).residual_mm;
    double before = 0, after = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (group_of[i] < 0 || out[i] ||
          without.sd_mm[row] > kForetold * search_.circumstances.sigma_mm[row]) {
        continue;
      }
      before += without.residual_mm[row] * without.residual_mm[row];
      after += with[row] * with[row];
      ++held.rows;
    }
    if (held.rows == 0) return {};
    const double rows = held.rows;
    held.before_mm = std::sqrt(before / rows);
    held.after_mm = std::sqrt(after / rows);
    return held;
  }

  // Residual mean square of a subset of the findings, nothing left out [mm^2].
  double MeanSquare(unsigned subset) const {
    const std::vector<bool>& out = search_.circumstances.left_out;
    const Eigen::VectorXd residual = ResidualOf(subset, out, more_);
    double sum = 0;
    int rows = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i]) continue;
      sum += std::pow(residual[static_cast<Eigen::Index>(i)], 2);
      ++rows;
    }
    return sum / std::max(rows, 1);
  }

  // log p(row | all but its block) of a subset of the findings, summed over the rows.
  double Score(unsigned subset, const std::vector<int>& block_of) const {
    constexpr double kFarthest = 5;  // Sigmas that a row may count for: robust.
    const std::vector<bool>& out = search_.circumstances.left_out;
    const Evidence::Foretold foretold =
        EvidenceOf(subset, out, more_).Foretell(block_of);
    double score = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (block_of[i] < 0 || out[i]) continue;
      const auto row = static_cast<Eigen::Index>(i);
      const double sd_mm =
          std::hypot(search_.circumstances.sigma_mm[row], foretold.sd_mm[row]);
      const double z = std::min(std::abs(foretold.residual_mm[row]) / sd_mm, kFarthest);
      score -= 0.5 * z * z + std::log(sd_mm);
    }
    return score;
  }

  // How much of the rows the baseline can be told of while their block is left out.
  double ForetoldShare(const std::vector<int>& block_of) const {
    const std::vector<bool>& out = search_.circumstances.left_out;
    const Evidence::Foretold foretold =
        EvidenceOf(NoFinding(), out, more_).Foretell(block_of);
    double told = 0, rows = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (block_of[i] < 0 || out[i]) continue;
      const auto row = static_cast<Eigen::Index>(i);
      rows += 1;
      told += foretold.sd_mm[row] <= kForetold * search_.circumstances.sigma_mm[row]
                  ? 1
                  : 0;
    }
    return rows > 0 ? told / rows : 1;
  }

  unsigned All() const { return (1U << more_.size()) - 1; }
  static unsigned NoFinding() { return 0; }
  std::size_t num_findings() const { return more_.size(); }

 private:
  Eigen::VectorXd ResidualOf(unsigned subset,
                             const std::vector<bool>& out,
                             const Lines& more) const {
    return EvidenceOf(subset, out, more).FitNuisances().residual_mm;
  }

  Evidence EvidenceOf(unsigned subset,
                      const std::vector<bool>& out,
                      const Lines& more) const {
    std::vector<Nuisance> nuisances = search_.circumstances.nuisances;
    for (std::size_t f = 0; f < more.size(); ++f) {
      if ((subset >> f & 1U) == 0) continue;
      nuisances.insert(nuisances.end(), more[f].begin(), more[f].end());
    }
    return {observed_, {search_.circumstances.sigma_mm, 0}, nuisances, out};
  }

  bool HasFreeForm() const {
    return std::ranges::any_of(search_.found, [&](const Found& found) {
      return candidates_[found.candidate].is_free();
    });
  }

  // What the others foretell of each row, fitted anew for every group.
  Eigen::VectorXd ResidualsChosenAnew(const std::vector<int>& group_of,
                                      int num_groups) const {
    Eigen::VectorXd residual_mm = observed_.residual_mm();
    for (int group = 0; group < num_groups; ++group) {
      std::vector<bool> out = search_.circumstances.left_out;
      for (std::size_t i = 0; i < out.size(); ++i) {
        if (group_of[i] == group) out[i] = true;
      }
      const Eigen::VectorXd with = ResidualOf(All(), out, Chosen(out));
      for (std::size_t i = 0; i < out.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (group_of[i] == group) residual_mm[row] = with[row];
      }
    }
    return residual_mm;
  }

  // The findings, the prior size of each table as the rows that are left say.
  Lines Chosen(const std::vector<bool>& out) const {
    Lines chosen = more_;
    for (std::size_t f = 0; f < more_.size(); ++f) {
      const Candidate& candidate = candidates_[search_.found[f].candidate];
      if (!candidate.is_free()) continue;
      const Evidence others = EvidenceOf(All() & ~(1U << f), out, more_);
      const Found& found = search_.found[f];
      const double scale_mm = LikeliestScale_mm(others, candidate, found.variant);
      for (Nuisance& line : chosen[f]) line.prior_sd *= scale_mm / found.scale_mm;
    }
    return chosen;
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const SearchResult& search_;
  Lines more_{};
};

std::string SetupOf(const Row& row) {
  return row.campaign + "|" + row.setup;
}

// Contiguous pieces of the time inside each setup or, where `by_home`, inside each
// homing session of it.
std::vector<int> TimeBlocks(const Observed& o, bool by_home) {
  std::map<std::string, std::vector<Eigen::Index>> by_setup;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    std::string key = SetupOf(o.row(i));
    if (by_home) key += "|" + o.row(i).home;
    by_setup[key].push_back(i);
  }
  std::vector<int> blocks(static_cast<std::size_t>(o.num_rows()), -1);
  for (auto& [setup, rows] : by_setup) {
    std::ranges::stable_sort(rows, {}, [&](Eigen::Index i) { return o.at(i).t_s; });
    for (std::size_t k = 0; k < rows.size(); ++k) {
      blocks[static_cast<std::size_t>(rows[k])] =
          static_cast<int>(k * kBlocks / rows.size());
    }
  }
  return blocks;
}

// Groups by a key; -1 for rows that cannot be left out.
template <typename Key>
std::vector<int> GroupsBy(const Observed& o, const Key& key_of, int most) {
  std::map<std::string, int> ids;
  std::vector<int> groups;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const std::string key = key_of(o.row(i));
    if (key.empty()) {
      groups.push_back(-1);
      continue;
    }
    const int id = ids.try_emplace(key, static_cast<int>(ids.size())).first->second;
    groups.push_back(id % most);
  }
  return groups;
}

std::string RunOf(const Row& row) {
  return row.rep ? std::to_string(*row.rep) : "";
}

std::string PoseOf(const Row& row) {
  std::string key;
  for (const double cmd_mm : row.cmd_mm) {
    key += Known(cmd_mm) ? std::to_string(std::llround(cmd_mm * 1e2)) + "," : "?,";
  }
  return key;
}

enum class Which : std::uint8_t { kInner, kEnds };

// Positions that were measured more than once. The ends of the axis read apart: beyond
// the last position there is nothing to interpolate between.
std::vector<int> PositionGroups(const Observed& o, Which which) {
  std::map<std::string, int> counts;
  const auto along = [&](Eigen::Index i) {
    Eigen::Index axis = 0;
    o.at(i).n.cwiseAbs().maxCoeff(&axis);
    return axis;
  };
  Vec3<double> low = Vec3<double>::Constant(1e300), high = -low;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const Eigen::Index axis = along(i);
    ++counts[PoseOf(o.row(i))];
    low[axis] = std::min(low[axis], o.at(i).q_mm[axis]);
    high[axis] = std::max(high[axis], o.at(i).q_mm[axis]);
  }
  const double most_repeated =
      static_cast<double>(o.num_rows()) / static_cast<double>(counts.size());
  std::vector<int> groups(static_cast<std::size_t>(o.num_rows()), -1);
  if (most_repeated < 2) return groups;
  std::map<std::string, int> ids;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const Eigen::Index axis = along(i);
    const double end_mm = 1e-3 * (high[axis] - low[axis]);
    const double q_mm = o.at(i).q_mm[axis];
    const bool is_end = q_mm - low[axis] < end_mm || high[axis] - q_mm < end_mm;
    if (is_end != (which == Which::kEnds)) continue;
    const int id =
        ids.try_emplace(PoseOf(o.row(i)), static_cast<int>(ids.size())).first->second;
    groups[static_cast<std::size_t>(i)] = id % kMostPositionFolds;
  }
  return groups;
}

double Factorial(std::size_t n) {
  return n < 2 ? 1 : static_cast<double>(n) * Factorial(n - 1);
}

// Shapley's share of each finding in the variance explained. What rows leave below the
// noise floor, by fitting it, is nobody's share.
std::vector<double> Shares(const Gainer& gainer, double floor_mm2) {
  const std::size_t n = gainer.num_findings();
  std::vector<double> worth(1U << n);
  for (unsigned subset = 0; subset < worth.size(); ++subset) {
    worth[subset] = std::max(gainer.MeanSquare(subset), floor_mm2);
  }
  const double explainable = std::max(worth[0] - floor_mm2, 1e-300);
  std::vector<double> shares(n, 0);
  for (std::size_t f = 0; f < n; ++f) {
    for (unsigned subset = 0; subset < worth.size(); ++subset) {
      if ((subset >> f & 1U) != 0) continue;
      const auto size = static_cast<std::size_t>(__builtin_popcount(subset));
      shares[f] += Factorial(size) * Factorial(n - size - 1) / Factorial(n) *
                   (worth[subset] - worth[subset | 1U << f]) / explainable;
    }
    shares[f] = std::clamp(shares[f], 0.0, 1.0);
  }
  return shares;
}

// Of all rows that count.
// The pure error of replicates, what was found taken out: a drift that has a name is no
// noise. Repeats that count the same whole steps do not show what these leave open. A
// campaign without replicates has what the richest model leaves.
double NoiseFloor_mm(const Observed& o,
                     const SearchResult& search,
                     const std::vector<Refined>& refined,
                     bool* from_replicates) {
  constexpr int kEnough = 5;
  Eigen::VectorXd left_mm = o.residual_mm();
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const bool is_named = refined[i].effect.effect >= 0;
    const Variant& variant = is_named ? refined[i].variant : search.found[i].variant;
    if (refined[i].sizes_mm.size() != variant.columns_mm.cols()) continue;
    left_mm -= variant.columns_mm * refined[i].sizes_mm;
  }
  const std::vector<bool>& out = search.circumstances.left_out;
  const PureError pure = PureErrorOf(o, left_mm, out, kEnough);
  double sum = 0;
  int rows = 0;
  *from_replicates = true;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i]) continue;
    const auto c = static_cast<std::size_t>(o.campaign_of()[i]);
    const bool is_pure = Known(pure.sigma_mm[c]);
    const double rounding_mm = RoundingSigma_mm(o, static_cast<Eigen::Index>(i));
    sum += std::pow(
        is_pure ? std::max(pure.sigma_mm[c], rounding_mm) : search.richest.sigma_mm[c],
        2);
    *from_replicates &= is_pure;
    ++rows;
  }
  return std::sqrt(sum / std::max(rows, 1));
}

// Where a block is most of a homing session, nothing tells where the machine stood in
// it: then a part of each session is left out in place of one session.
std::vector<int> BlocksFor(const Observed& observed, const Gainer& gainer) {
  constexpr double kLeastTold = 0.7;
  std::vector<int> blocks = TimeBlocks(observed, /*by_home=*/false);
  const double told = gainer.ForetoldShare(blocks);
  if (told >= kLeastTold) return blocks;
  std::vector<int> by_home = TimeBlocks(observed, /*by_home=*/true);
  return gainer.ForetoldShare(by_home) > told ? by_home : blocks;
}

}  // namespace

GainFigures GainOf(const Observed& observed,
                   const std::vector<Candidate>& candidates,
                   const SearchResult& search,
                   const std::vector<Refined>& refined,
                   GainDepth depth) {
  // The freedom of form that each finding is granted may foretell or mislead: as the
  // rows left out say.
  const Gainer free(observed, candidates, search, refined, /*has_freedom=*/true);
  const std::vector<int> blocks = BlocksFor(observed, free);
  const Gainer strict(observed, candidates, search, refined, /*has_freedom=*/false);
  const double free_score = free.Score(free.All(), blocks);
  const double strict_score = strict.Score(strict.All(), blocks);
  const Gainer& gainer = free_score >= strict_score ? free : strict;
  GainFigures gain;
  gain.noise_floor_mm =
      NoiseFloor_mm(observed, search, refined, &gain.floor_from_replicates);
  gain.blocks = gainer.LeaveOut(blocks);
  if (depth == GainDepth::kAll && !search.found.empty()) {
    gain.runs = gainer.LeaveOut(GroupsBy(observed, RunOf, kMostPositionFolds));
    const auto leave_out = [&](Which which) {
      return gainer.LeaveOut(PositionGroups(observed, which), /*chooses_sizes=*/true);
    };
    gain.positions = leave_out(Which::kInner);
    gain.positions_as_fitted = gainer.LeaveOut(PositionGroups(observed, Which::kInner));
    gain.ends = leave_out(Which::kEnds);
  }
  if (!search.found.empty()) {
    const double floor2 = gain.noise_floor_mm * gain.noise_floor_mm;
    const double before2 = gain.blocks.before_mm * gain.blocks.before_mm;
    const double after2 = gain.blocks.after_mm * gain.blocks.after_mm;
    gain.explained_fraction =
        std::min(1.0, (before2 - after2) / std::max(before2 - floor2, 1e-300));
    gain.shares = Shares(gainer, floor2);
    const double with = std::max(free_score, strict_score);
    for (std::size_t f = 0; f < gainer.num_findings(); ++f) {
      const double without = gainer.Score(gainer.All() & ~(1U << f), blocks);
      gain.scores.push_back(with - without);
    }
  }
  return gain;
}

}  // namespace caltwin
