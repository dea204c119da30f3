// Whether the probe triggers on the same side of the surface in every campaign.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

/// What touches read in the mean over opposite faces: minus the pre-travel and half the
/// gap, more the tip's error and half the artefact's. Where the artefact stands
/// cancels.
struct FaceMean {
  std::string campaign{};
  double mean_mm = 0, sd_mm = 0;
};

/// Scale of each axis where a gauge read it, else kUnknown.
std::array<double, 3> GaugedScales(const std::vector<RowSeries>& all) {
  constexpr std::size_t kFewestRows = 5;
  std::array<double, 3> scales = {kUnknown, kUnknown, kUnknown};
  for (const RowSeries& series : all) {
    if (series.first->kind == RowKind::kTouch || series.rows.size() < kFewestRows) {
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double n = series.first->n[axis];
      if (!Known(n) || std::abs(n) < 0.99) continue;
      scales[axis] = FitSeries(series).slope;
    }
  }
  return scales;
}

/// Values of touches, linear in what opposite faces tell apart: scale of each axis, and
/// of each setup the mean, the place of its artefact and its turn about the vertical.
///
///   value = mean + (place + turn z x q) . n - sum over axes of scale q n
class FaceFit {
 public:
  /// `reversed`: the campaign whose readings are taken with the other sign.
  FaceFit(const std::vector<RowSeries>& all,
          const std::array<double, 3>& scales,
          const std::string& reversed = "") {
    for (const RowSeries& series : all) {
      if (series.first->kind == RowKind::kTouch) Place(*series.first);
    }
    if (at_.size() > kMostSetups) at_.clear();
    normal_ = Eigen::MatrixXd::Zero(Size(), Size());
    right_ = Eigen::VectorXd::Zero(Size());
    AddPriors(scales);
    for (const RowSeries& series : all) {
      if (series.first->kind != RowKind::kTouch || at_.empty()) continue;
      const double sign = series.first->campaign == reversed ? -1 : 1;
      for (const Row* row : series.rows) Add(*row, sign * row->value_mm);
    }
  }

  std::vector<FaceMean> Means() const {
    const PivotedCholesky solver(normal_);
    const Eigen::VectorXd fitted = solver.Solve(right_);
    std::vector<FaceMean> means;
    for (const auto& [setup, at] : at_) {
      const double variance = solver.Solve(Eigen::VectorXd::Unit(Size(), at))[at];
      means.push_back({setup.first, fitted[at], std::sqrt(variance)});
    }
    return means;
  }

 private:
  static constexpr Eigen::Index kPerSetup = 5;
  static constexpr std::size_t kMostSetups = 60;      ///< Beyond: not looked at.
  static constexpr double kSigma_mm = MmFromUm(5.0);  ///< Scatter and crooked faces.

  Eigen::Index Size() const {
    return 3 + kPerSetup * static_cast<Eigen::Index>(at_.size());
  }

  Eigen::Index Place(const Row& row) {
    return at_.try_emplace({row.campaign, row.setup}, Size()).first->second;
  }

  void AddPrior(Eigen::Index at, double value, double sd) {
    normal_(at, at) += 1 / (sd * sd);
    right_[at] += value / (sd * sd);
  }

  void AddPriors(const std::array<double, 3>& scales) {
    constexpr double kGauged = 1e-5, kWide = 0.02, kMean_mm = 1, kPlace_mm = 10;
    constexpr double kTurn_rad = 0.02;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_gauged = Known(scales[k]);
      AddPrior(static_cast<Eigen::Index>(k),
               is_gauged ? scales[k] : 0,
               is_gauged ? kGauged : kWide);
    }
    for (const auto& [setup, at] : at_) {
      AddPrior(at, 0, kMean_mm);
      for (Eigen::Index k = 1; k <= 3; ++k) AddPrior(at + k, 0, kPlace_mm);
      AddPrior(at + 4, 0, kTurn_rad);
    }
  }

  void Add(const Row& row, double value_mm) {
    const Eigen::Index at = Place(row);
    Eigen::VectorXd terms = Eigen::VectorXd::Zero(Size());
    terms[at] = 1;
    Eigen::Vector3d n = Eigen::Vector3d::Zero(), q_mm = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (Known(row.n[k])) n[i] = row.n[k];
      if (Known(row.cmd_mm[k])) q_mm[i] = row.cmd_mm[k];
    }
    terms.segment<3>(at + 1) = n;
    terms[at + 4] = n[1] * q_mm[0] - n[0] * q_mm[1];
    terms.head<3>() = -q_mm.cwiseProduct(n);
    constexpr double kWeight = 1 / (kSigma_mm * kSigma_mm);
    normal_ += kWeight * terms * terms.transpose();
    right_ += kWeight * value_mm * terms;
  }

  std::map<std::pair<std::string, std::string>, Eigen::Index> at_{};
  Eigen::MatrixXd normal_{};
  Eigen::VectorXd right_{};
};

/// The mean of one campaign and of all others, each setup by its certainty.
struct Two {
  FaceMean own{}, others{};
};

Two Split(const std::vector<FaceMean>& means, const std::string& campaign) {
  std::array<double, 2> sum_mm{}, weight{};
  for (const FaceMean& mean : means) {
    const std::size_t which = mean.campaign == campaign ? 0 : 1;
    sum_mm[which] += mean.mean_mm / (mean.sd_mm * mean.sd_mm);
    weight[which] += 1 / (mean.sd_mm * mean.sd_mm);
  }
  const auto mean_of = [&](std::size_t which) {
    const double scale = 1 / std::max(weight[which], 1e-300);
    return FaceMean{campaign, sum_mm[which] * scale, std::sqrt(scale)};
  };
  return {mean_of(0), mean_of(1)};
}

// As read it contradicts the others, the other way round it agrees with them.
bool IsReversed(const Two& as_read, const Two& turned) {
  constexpr double kSure = 5, kAgrees = 0.4, kContradicts = 1.4;
  constexpr double kLeast_mm = MmFromUm(5.0);
  const double late_mm = -as_read.others.mean_mm;
  const double sd_mm = std::hypot(as_read.own.sd_mm, as_read.others.sd_mm);
  return late_mm > std::max(kLeast_mm, kSure * sd_mm) &&
         std::abs(as_read.own.mean_mm + late_mm) > kContradicts * late_mm &&
         std::abs(turned.own.mean_mm + late_mm) < kAgrees * late_mm;
}

}  // namespace

// A probe comes upon a face against its normal, which points out of the material; it
// leaves along it, but not without having come.
void DoubtApproach(const RowTable& table, std::vector<Doubt>* doubts) {
  constexpr int kFewest = 4;
  struct Counted {
    int known = 0, outward = 0;
  };
  std::map<std::string, Counted> campaigns;
  for (const Row& row : table.rows) {
    if (row.kind != RowKind::kTouch) continue;
    const double sense = SenseAlongNormal(row);
    if (std::abs(sense) < 0.5) continue;
    Counted& counted = campaigns[row.campaign];
    counted.known += 1;
    counted.outward += sense > 0 ? 1 : 0;
  }
  for (const auto& [campaign, counted] : campaigns) {
    if (counted.known < kFewest || counted.outward < counted.known) continue;
    doubts->push_back(
        {.kind = "reversed_sign",
         .message =
             fmt::format("all {} touches of campaign {} move along the normal of "
                         "their face: out of the material",
                         counted.known,
                         campaign),
         .hint = "nx ny nz point out of the material, dir_ is the way the axis moved: "
                 "one of both has the other sign",
         .refuse = true});
  }
}

void DoubtFaces(const std::vector<RowSeries>& all, std::vector<Doubt>* doubts) {
  const std::array<double, 3> scales = GaugedScales(all);
  const std::vector<FaceMean> means = FaceFit(all, scales).Means();
  std::set<std::string> campaigns;
  for (const FaceMean& mean : means) campaigns.insert(mean.campaign);
  if (campaigns.size() < 2) return;
  for (const std::string& campaign : campaigns) {
    const Two as_read = Split(means, campaign);
    const Two turned = Split(FaceFit(all, scales, campaign).Means(), campaign);
    if (!IsReversed(as_read, turned)) continue;
    doubts->push_back(
        {.kind = "reversed_sign",
         .message = fmt::format(
             "over opposite faces the touches of campaign {} read {:+.3g} um in the "
             "mean, all others {:+.3g} um; with the other sign they would read {:+.3g}",
             campaign,
             UmFromMm(as_read.own.mean_mm),
             UmFromMm(as_read.others.mean_mm),
             UmFromMm(turned.own.mean_mm)),
         .hint =
             fmt::format("a probe triggers late, never early: value_mm of campaign {} "
                         "has the other "
                         "sign (of a touch it is reported minus nominal), or its "
                         "artefact is {:.3g} "
                         "um off: measure that, or leave the campaign out",
                         campaign,
                         2 * UmFromMm(as_read.own.mean_mm - as_read.others.mean_mm)),
         .refuse = true});
    return;
  }
}

}  // namespace caltwin
