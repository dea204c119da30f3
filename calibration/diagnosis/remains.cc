#include "calibration/diagnosis/remains.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/rounding.h"
#include "calibration/diagnosis/weighing.h"
#include "calibration/estimate/f_test.h"

namespace caltwin {
namespace {

constexpr double kMostChance = 1e-4;

// Spearman's rank correlation without ties to mend; 0 of fewer than five.
double RankCorrelation(const std::vector<double>& one,
                       const std::vector<double>& other) {
  constexpr std::size_t kFewest = 5;
  if (one.size() < kFewest) return 0;
  const auto ranks = [](const std::vector<double>& values) {
    std::vector<double> ranks_of;
    for (const double value : values) {
      const auto below =
          std::ranges::count_if(values, [&](double each) { return each < value; });
      const auto same = std::ranges::count(values, value);
      ranks_of.push_back(static_cast<double>(below) +
                         static_cast<double>(same - 1) / 2);
    }
    return ranks_of;
  };
  const std::vector<double> a = ranks(one), b = ranks(other);
  const double mean = static_cast<double>(a.size() - 1) / 2;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
    ab += (a[i] - mean) * (b[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

// Whether every campaign went through its places once, in order: then a drift of the
// machine and an error along its travel look alike.
bool IsTimePlace(const Observed& observed) {
  constexpr double kAlike = 0.95;
  std::map<int, std::vector<Eigen::Index>> campaigns;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    campaigns[observed.campaign_of()[static_cast<std::size_t>(i)]].push_back(i);
  }
  return std::ranges::all_of(campaigns, [&](const auto& campaign) {
    double most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> times_s, places_mm;
      for (const Eigen::Index i : campaign.second) {
        times_s.push_back(observed.at(i).t_s);
        places_mm.push_back(observed.at(i).q_mm[axis]);
      }
      most = std::max(most, std::abs(RankCorrelation(times_s, places_mm)));
    }
    return most > kAlike;
  });
}

// Whether what is left comes back where the same is measured again: scatter of the
// means over that of the repeats, Fisher's F. A wander of the machine does not.
bool ComesBack(const Observed& observed,
               const Eigen::VectorXd& residual_mm,
               const std::vector<bool>& left_out) {
  constexpr double kFewest = 6;
  struct Cell {
    double sum = 0, sum2 = 0, num = 0;
  };
  std::map<std::string, Cell> cells;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (left_out[static_cast<std::size_t>(i)]) continue;
    Cell& cell = cells[ReplicateKey(observed, i)];
    cell.sum += residual_mm[i];
    cell.sum2 += residual_mm[i] * residual_mm[i];
    cell.num += 1;
  }
  double between2 = 0, within2 = 0, between = 0, within = 0;
  for (const auto& [key, cell] : cells) {
    if (cell.num < 2) continue;
    between2 += cell.sum * cell.sum / cell.num;
    within2 += cell.sum2 - cell.sum * cell.sum / cell.num;
    between += 1;
    within += cell.num - 1;
  }
  if (between < kFewest || within < kFewest) return false;
  const double f = between2 / between * within / std::max(within2, 1e-300);
  return FUpperTail(f, between, within) < kMostChance;
}

// What may be a slow wander of the machine, and not an error that stays where it is.
double Wander_mm2_per_s(const Observed& observed, const SearchResult& search) {
  if (search.wander_mm2_per_s <= 0 || IsTimePlace(observed)) return 0;
  const Circumstances& circumstances = search.circumstances;
  const Evidence still(observed,
                       {circumstances.sigma_mm, 0},
                       circumstances.nuisances,
                       circumstances.left_out);
  const bool comes_back =
      ComesBack(observed, still.FitNuisances().residual_mm, circumstances.left_out);
  return comes_back ? 0 : search.wander_mm2_per_s;
}

// By campaign: what whole steps leave open, which repeats that count the same steps do
// not show.
std::vector<double> RoundingOf_mm(const Observed& observed) {
  std::vector<double> sum(observed.campaigns().size(), 0), rows = sum;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const auto c =
        static_cast<std::size_t>(observed.campaign_of()[static_cast<std::size_t>(i)]);
    sum[c] += std::pow(RoundingSigma_mm(observed, i), 2);
    rows[c] += 1;
  }
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] = std::sqrt(sum[c] / rows[c]);
  return sum;
}

}  // namespace

std::vector<Floor> FloorsOf(const Observed& observed, const SearchResult& search) {
  constexpr int kEnough = 10;
  // Drift between replicates and outliers among them would raise the floor.
  constexpr double kAlike = 1.3;
  const PureError pure = PureErrorOf(observed, kEnough);
  const std::vector<double> rounding_mm = RoundingOf_mm(observed);
  std::vector<Floor> floors;
  for (std::size_t c = 0; c < pure.sigma_mm.size(); ++c) {
    const double richest_mm = search.richest.sigma_mm[c];
    const bool is_pure =
        Known(pure.sigma_mm[c]) && pure.sigma_mm[c] < kAlike * richest_mm;
    floors.push_back({is_pure ? std::max(pure.sigma_mm[c], rounding_mm[c]) : richest_mm,
                      is_pure ? pure.dof[c] : search.richest.dof[c]});
  }
  return floors;
}

bool Remains::IsThere() const {
  constexpr double kLeastTimes = 2;
  return rms_mm > kLeastTimes * floor_mm && chance < kMostChance;
}

Remains RemainsOf(const Observed& observed, const SearchResult& search) {
  constexpr double kEnoughDof = 6;
  // A stated sigma may be wrong by a factor of two: as sure as a variance of so many
  // degrees of freedom.
  constexpr double kStatedDof = 4;
  const Eigen::VectorXd& sigma_mm = search.circumstances.sigma_mm;
  const Evidence evidence(observed,
                          {sigma_mm, Wander_mm2_per_s(observed, search)},
                          search.circumstances.nuisances,
                          search.circumstances.left_out);
  double floor2 = 0, sigma2 = 0, rows = 0, floor_dof = 0;
  const std::vector<Floor> floors = FloorsOf(observed, search);
  for (const Floor& floor : floors) {
    if (floor.dof >= kEnoughDof) floor_dof += floor.dof;
  }
  for (Eigen::Index i = 0; i < sigma_mm.size(); ++i) {
    if (search.circumstances.left_out[static_cast<std::size_t>(i)]) continue;
    const auto c =
        static_cast<std::size_t>(observed.campaign_of()[static_cast<std::size_t>(i)]);
    const bool is_known = floors[c].dof >= kEnoughDof;
    const double used2 = sigma_mm[i] * sigma_mm[i];
    sigma2 += used2;
    floor2 += is_known ? std::pow(floors[c].sigma_mm, 2) : used2;
    rows += 1;
  }
  rows = std::max(rows, 1.0);
  const double dof = std::max(evidence.dof(), 1.0);
  // That noise alone leaves so much more than the floor.
  const auto chance_of = [&](const Evidence& left) {
    const double f = left.chi2() / dof * sigma2 / std::max(floor2, 1e-300);
    return FUpperTail(f, dof, std::max(floor_dof, kStatedDof));
  };
  bool wanders_most = search.wander_mm2_per_s >= MostWander_mm2_per_s();
  if (wanders_most) {
    // A few rows of noise may wander as well: only where it is no noise.
    const Evidence still(observed,
                         {sigma_mm, 0},
                         search.circumstances.nuisances,
                         search.circumstances.left_out);
    wanders_most = chance_of(still) < kMostChance;
  }
  return {.rms_mm = std::sqrt(evidence.chi2() / dof * sigma2 / rows),
          .floor_mm = std::sqrt(floor2 / rows),
          .chance = chance_of(evidence),
          .wanders_most = wanders_most};
}

}  // namespace caltwin
