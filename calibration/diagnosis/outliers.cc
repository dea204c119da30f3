#include "calibration/diagnosis/outliers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "sim/base/dense.h"
#include "sim/base/median.h"

namespace caltwin {
namespace {

constexpr double kMostOutliers = 0.05;
constexpr std::size_t kNamedTaken = 14;
constexpr std::size_t kFreeTaken = 10;
// Hopeless candidates only cost degrees of freedom.
constexpr double kWorthTaking_nats = -7;

// Of how many rows' making the visible part of an effect is: (sum v^2)^2 / sum v^4.
double RowsBehind(const Evidence& evidence, const Eigen::VectorXd& effect_mm) {
  const Eigen::ArrayXd v2 = evidence.Left(evidence.Whiten(effect_mm)).array().square();
  return v2.sum() * v2.sum() / std::max(v2.square().sum(), 1e-300);
}

// All columns of the richest model, white and in units of their priors.
Eigen::MatrixXd ColumnsOf(const Observed& observed,
                          const std::vector<Candidate>& candidates,
                          const Weighing& weighing,
                          const Circumstances& circumstances) {
  std::vector<Eigen::VectorXd> all;
  for (const Nuisance& nuisance : circumstances.nuisances) {
    all.emplace_back(nuisance.column_mm * nuisance.prior_sd);
  }
  // What a handful of rows makes would explain them, and hide that they are outliers.
  constexpr double kFewestRows = 4;
  const Evidence evidence(
      observed, {circumstances.sigma_mm, 0}, circumstances.nuisances);
  std::size_t named = 0, free = 0;
  for (const Weighed& weighed : weighing.ranked) {
    const Candidate& candidate = candidates[weighed.candidate];
    if (weighed.log_odds < kWorthTaking_nats || weighed.sizes_mm.size() == 0) continue;
    std::size_t& taken = candidate.is_free() ? free : named;
    if (taken >= (candidate.is_free() ? kFreeTaken : kNamedTaken)) continue;
    const Variant& variant = candidate.variants[weighed.variant];
    if (RowsBehind(evidence, variant.columns_mm * weighed.sizes_mm) < kFewestRows) {
      continue;
    }
    ++taken;
    for (Eigen::Index k = 0; k < variant.columns_mm.cols(); ++k) {
      const double relative = candidate.is_free() ? candidate.free_prior[k] : 1;
      all.emplace_back(variant.columns_mm.col(k) * weighed.scale_mm *
                       std::sqrt(relative));
    }
  }
  Eigen::MatrixXd columns(observed.num_rows(), static_cast<Eigen::Index>(all.size()));
  for (std::size_t k = 0; k < all.size(); ++k) {
    columns.col(static_cast<Eigen::Index>(k)) = all[k];
  }
  return circumstances.sigma_mm.cwiseInverse().asDiagonal() * columns;
}

struct Ridge {
  Eigen::VectorXd residual{};  ///< White.
  Eigen::VectorXd leverage{};
};

// By QR of the columns over an identity, since columns in units of their priors differ
// by ten orders of magnitude.
Ridge FitRidge(const Eigen::MatrixXd& columns,
               const Eigen::VectorXd& white,
               const Eigen::VectorXd& keep) {
  const Eigen::Index n = columns.rows(), p = columns.cols();
  Eigen::MatrixXd tall(n + p, p);
  tall.topRows(n) = keep.asDiagonal() * columns;
  tall.bottomRows(p).setIdentity();
  const QrOf qr(tall);
  Eigen::VectorXd long_white = Eigen::VectorXd::Zero(n + p);
  long_white.head(n) = keep.cwiseProduct(white);
  const Eigen::VectorXd turned = qr.Turned(long_white);
  const Eigen::VectorXd x = qr.SolveR(turned.head(p));
  // Leverage: rows of X R^-1.
  const Eigen::MatrixXd half = qr.SolveTransposedR(columns.transpose());
  return {.residual = white - columns * x,
          .leverage = half.colwise().squaredNorm().transpose()};
}

// Deleted residuals: as if each row had not taken part. A row left out already did not.
double Deleted(const Ridge& ridge, const Eigen::VectorXd& keep, Eigen::Index i) {
  const double h = std::min(ridge.leverage[i], 0.999);
  return keep[i] > 0 ? ridge.residual[i] / std::sqrt(1 - h)
                     : ridge.residual[i] / std::sqrt(1 + ridge.leverage[i]);
}

class Judge {
 public:
  Judge(const Observed& observed,
        Eigen::MatrixXd columns,
        Eigen::VectorXd white,
        const std::vector<bool>& suspects)
      : observed_(observed),
        columns_(std::move(columns)),
        white_(std::move(white)),
        suspects_(suspects),
        keep_(Eigen::VectorXd::Ones(observed.num_rows())) {
    for (Eigen::Index i = 0; i < keep_.size(); ++i) {
      if (suspects_[static_cast<std::size_t>(i)]) keep_[i] = 0;
    }
  }

  void Run() {
    const auto most =
        static_cast<int>(kMostOutliers * static_cast<double>(keep_.size()));
    ridge_ = FitRidge(columns_, white_, keep_);
    for (int found = 0; found < most;) {
      const int more = LeaveOutFarthest(most - found);
      if (more == 0) break;
      found += more;
      ridge_ = FitRidge(columns_, white_, keep_);
    }
    TakeBack();
  }

  Richest Take(const Eigen::VectorXd& sigma_mm) const {
    const std::size_t num_campaigns = observed_.campaigns().size();
    Richest richest{.residual_mm = ridge_.residual.cwiseProduct(sigma_mm),
                    .leverage = ridge_.leverage,
                    .sigma_mm = std::vector<double>(num_campaigns, 0),
                    .dof = std::vector<double>(num_campaigns, 0)};
    for (Eigen::Index i = 0; i < keep_.size(); ++i) {
      richest.is_outlier.push_back(keep_[i] == 0);
      if (keep_[i] == 0) continue;
      const auto c = CampaignOf(i);
      richest.sigma_mm[c] += std::pow(richest.residual_mm[i], 2);
      richest.dof[c] += 1 - std::min(ridge_.leverage[i], 1.0);
    }
    for (std::size_t c = 0; c < num_campaigns; ++c) {
      richest.sigma_mm[c] =
          std::max(std::sqrt(richest.sigma_mm[c] / std::max(richest.dof[c], 1.0)),
                   RoundedTo_mm(observed_, observed_.campaigns()[c]));
    }
    return richest;
  }

 private:
  std::size_t CampaignOf(Eigen::Index i) const {
    return static_cast<std::size_t>(
        observed_.campaign_of()[static_cast<std::size_t>(i)]);
  }

  // Robust spread of each campaign's deleted residuals, white.
  std::vector<double> Spreads() const {
    std::vector<std::vector<double>> sizes(observed_.campaigns().size());
    for (Eigen::Index i = 0; i < keep_.size(); ++i) {
      if (keep_[i] > 0)
        sizes[CampaignOf(i)].push_back(std::abs(Deleted(ridge_, keep_, i)));
    }
    std::vector<double> spreads;
    for (const auto& of_campaign : sizes) {
      if (of_campaign.empty()) {
        spreads.push_back(1);
        continue;
      }
      const double sigma = kSigmaOfMedian * Median(of_campaign);
      double sum = 0;
      for (const double size : of_campaign) {
        sum += std::pow(std::min(size, kOutlier_sigma * sigma), 2);
      }
      // The larger of both: a median alone is poor in small campaigns.
      const double rms = std::sqrt(sum / static_cast<double>(of_campaign.size()));
      spreads.push_back(std::max(sigma, 0.9 * rms));
    }
    return spreads;
  }

  // Leaves out the farthest rows beyond the limit, half of them at most, so that what
  // they masked shows.
  int LeaveOutFarthest(int most) {
    const std::vector<double> spreads = Spreads();
    std::vector<std::pair<double, Eigen::Index>> far;
    for (Eigen::Index i = 0; i < keep_.size(); ++i) {
      if (keep_[i] == 0) continue;
      const double size =
          std::abs(Deleted(ridge_, keep_, i)) / std::max(spreads[CampaignOf(i)], 1e-9);
      if (size > kOutlier_sigma) far.emplace_back(size, i);
    }
    std::ranges::sort(far, std::ranges::greater{});
    const int take = std::min({most,
                               static_cast<int>(far.size()),
                               std::max(1, static_cast<int>(far.size() / 2))});
    for (int k = 0; k < take; ++k) keep_[far[static_cast<std::size_t>(k)].second] = 0;
    return take;
  }

  // A far row drags others along while it takes part: rows that agree with all that is
  // left were left out for its sake.
  void TakeBack() {
    const std::vector<double> spreads = Spreads();
    bool is_any_back = false;
    for (Eigen::Index i = 0; i < keep_.size(); ++i) {
      if (keep_[i] > 0 || suspects_[static_cast<std::size_t>(i)]) continue;
      const double size =
          std::abs(Deleted(ridge_, keep_, i)) / std::max(spreads[CampaignOf(i)], 1e-9);
      if (size > kOutlier_sigma) continue;
      keep_[i] = 1;
      is_any_back = true;
    }
    if (is_any_back) ridge_ = FitRidge(columns_, white_, keep_);
  }

  const Observed& observed_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd white_;
  const std::vector<bool>& suspects_;
  Eigen::VectorXd keep_;
  Ridge ridge_{};
};

}  // namespace

Richest JudgeRows(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Weighing& weighing,
                  const Circumstances& circumstances,
                  const std::vector<bool>& suspects) {
  Judge judge(
      observed,
      ColumnsOf(observed, candidates, weighing, circumstances),
      circumstances.sigma_mm.cwiseInverse().cwiseProduct(observed.residual_mm()),
      suspects);
  judge.Run();
  return judge.Take(circumstances.sigma_mm);
}

std::vector<bool> LoneRows(const Observed& observed) {
  constexpr std::size_t kFewestReplicates = 4, kMost = 3;
  constexpr double kFar = 10;
  std::map<std::string, std::vector<Eigen::Index>> groups;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    groups[ReplicateKey(observed, i)].push_back(i);
  }
  std::vector<double> off_mm(static_cast<std::size_t>(observed.num_rows()), 0);
  std::vector<std::vector<std::size_t>> rows(observed.campaigns().size());
  for (const auto& [key, members] : groups) {
    if (members.size() < kFewestReplicates) continue;
    std::vector<double> values_mm;
    for (const Eigen::Index i : members) {
      values_mm.push_back(observed.residual_mm()[i]);
    }
    const double middle_mm = Median(values_mm);
    for (std::size_t k = 0; k < members.size(); ++k) {
      const auto i = static_cast<std::size_t>(members[k]);
      off_mm[i] = std::abs(values_mm[k] - middle_mm);
      rows[static_cast<std::size_t>(observed.campaign_of()[i])].push_back(i);
    }
  }
  std::vector<bool> is_lone(off_mm.size(), false);
  for (const auto& campaign : rows) {
    std::vector<double> sizes_mm;
    for (const std::size_t i : campaign) sizes_mm.push_back(off_mm[i]);
    if (sizes_mm.empty()) continue;
    const double limit_mm = kFar * kSigmaOfMedian * Median(sizes_mm);
    const auto is_far = [&](std::size_t i) {
      return limit_mm > 0 && off_mm[i] > limit_mm;
    };
    if (static_cast<std::size_t>(std::ranges::count_if(campaign, is_far)) > kMost) {
      continue;
    }
    for (const std::size_t i : campaign) is_lone[i] = is_far(i);
  }
  return is_lone;
}

}  // namespace caltwin
