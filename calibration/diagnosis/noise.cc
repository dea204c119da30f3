#include "calibration/diagnosis/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/rounding.h"
#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kLeastSigma_mm = 1e-7;

}  // namespace

std::string ReplicateKey(const Observed& o, Eigen::Index i) {
  const Row& row = o.row(i);
  const At& at = o.at(i);
  std::string key = row.campaign + "|" + row.setup + "|" + row.feature;
  if (DiagnosedAs(o.machine()).StandsAnewWhenHomed()) key += "|" + row.home;
  const auto add = [&](double value, double step) {
    key += "|";
    key += Known(value) ? std::to_string(std::llround(value / step)) : "?";
  };
  for (std::size_t k = 0; k < 3; ++k) {
    add(row.cmd_mm[k], 1e-3);
    add(row.dir[k], 1e-2);
    add(row.n[k], 1e-3);
    add(at.probe_off_mm[static_cast<int>(k)], 1e-3);
  }
  add(row.feed_mm_s, 1e-3);
  add(row.load_n, 1e-2);
  add(row.probe_angle_deg, 1e-2);
  add(row.artefact_turn_deg, 1e-2);
  // Of a printer's heaters: between rooms that warm, repeats differ by less.
  if (at.station) {
    for (const double temp_c :
         {row.temp_nozzle_c, row.temp_bed_c, row.temp_chamber_c}) {
      add(temp_c, 1);
    }
    key += at.is_wiped ? "|wiped" : "|";
  }
  return key;
}

Whitener::Whitener(const Observed& observed, const Noise& noise)
    : wanders_(noise.wander_mm2_per_s > 0),
      inverse_sd_(noise.sigma_mm.cwiseInverse()),
      log_det_(2 * noise.sigma_mm.array().log().sum()) {
  if (!wanders_) return;
  order_.resize(static_cast<std::size_t>(observed.num_rows()));
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::stable_sort(
      order_, {}, [&](Eigen::Index i) { return observed.row(i).row; });
  Eigen::Matrix3d p = Eigen::Matrix3d::Zero();
  double before_s = observed.at(order_.front()).t_s;
  log_det_ = 0;
  for (const Eigen::Index i : order_) {
    const double step_s = std::max(0.0, observed.at(i).t_s - before_s);
    before_s = observed.at(i).t_s;
    p.diagonal().array() += noise.wander_mm2_per_s * step_s;
    const Eigen::Vector3d h = observed.MotionSign(i) * observed.at(i).n;
    const Eigen::Vector3d ph = p * h;
    const double variance = h.dot(ph) + noise.sigma_mm[i] * noise.sigma_mm[i];
    direction_.push_back(h);
    gain_.emplace_back(ph / variance);
    p -= ph * ph.transpose() / variance;
    inverse_sd_[i] = 1 / std::sqrt(variance);
    log_det_ += std::log(variance);
  }
}

Eigen::MatrixXd Whitener::operator()(const Eigen::MatrixXd& columns_mm) const {
  if (!wanders_) return inverse_sd_.asDiagonal() * columns_mm;
  Eigen::MatrixXd white(columns_mm.rows(), columns_mm.cols());
  // A row waits for the one before it: several columns side by side do not. Plain
  // arrays, which every compiler keeps in registers.
  constexpr Eigen::Index kAtOnce = 8;
  using Several = std::array<double, kAtOnce>;
  for (Eigen::Index first = 0; first < columns_mm.cols(); first += kAtOnce) {
    const Eigen::Index num = std::min(kAtOnce, columns_mm.cols() - first);
    Several x{}, y{}, z{}, innovation{};
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const Eigen::Index i = order_[k];
      const Eigen::Vector3d &n = direction_[k], &gain = gain_[k];
      for (Eigen::Index j = 0; j < num; ++j) innovation[j] = columns_mm(i, first + j);
      for (std::size_t j = 0; j < kAtOnce; ++j) {
        innovation[j] -= n[0] * x[j] + n[1] * y[j] + n[2] * z[j];
        x[j] += gain[0] * innovation[j];
        y[j] += gain[1] * innovation[j];
        z[j] += gain[2] * innovation[j];
      }
      for (Eigen::Index j = 0; j < num; ++j) {
        white(i, first + j) = innovation[j] * inverse_sd_[i];
      }
    }
  }
  return white;
}

double RoundedTo_mm(const Observed& observed, const std::string& name) {
  const DataHeader& header = observed.header();
  const double counted_mm = CountedSigma_mm(observed, name);
  const auto campaign = header.campaigns.find(name);
  if (campaign == header.campaigns.end()) return counted_mm;
  const auto instrument = header.instruments.find(campaign->second.instrument);
  if (instrument == header.instruments.end()) return counted_mm;
  return std::max(counted_mm,
                  MmFromUm(instrument->second.resolution_um) / std::sqrt(12.0));
}

namespace {

using Groups = std::map<std::string, std::vector<Eigen::Index>>;

Groups ReplicatesOf(const Observed& observed, const std::vector<bool>& left_out) {
  Groups groups;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (left_out[static_cast<std::size_t>(i)]) continue;
    groups[ReplicateKey(observed, i)].push_back(i);
  }
  return groups;
}

// Squares that n readings of one true value add to n - 1 degrees of freedom.
double AboutMean(const std::vector<Eigen::Index>& members,
                 const Eigen::VectorXd& left) {
  double mean = 0, sum = 0;
  for (const Eigen::Index i : members) mean += left[i];
  mean /= static_cast<double>(members.size());
  for (const Eigen::Index i : members) sum += std::pow(left[i] - mean, 2);
  return sum;
}

// The same from each reading to the next: a slow drift cancels.
double AboutNext(const std::vector<Eigen::Index>& members,
                 const Eigen::VectorXd& left) {
  double sum = 0;
  for (std::size_t k = 1; k < members.size(); ++k) {
    sum += std::pow(left[members[k]] - left[members[k - 1]], 2) / 2;
  }
  return sum;
}

// Without times the rows' order stands for them, where it plainly shows: many readings
// that follow their neighbours twice as closely as their mean.
double AboutNextWhereItDrifts(const std::vector<Eigen::Index>& members,
                              const Eigen::VectorXd& left) {
  constexpr std::size_t kMany = 20;
  const double about_mean = AboutMean(members, left);
  if (members.size() < kMany) return about_mean;
  const double about_next = AboutNext(members, left);
  return 4 * about_next < about_mean ? about_next : about_mean;
}

template <typename Squares>
PureError Pooled(const Observed& observed,
                 const Groups& groups,
                 int least_dof,
                 const Squares& squares) {
  const std::size_t num_campaigns = observed.campaigns().size();
  std::vector<double> sum(num_campaigns, 0);
  PureError pure{.sigma_mm = std::vector<double>(num_campaigns, kUnknown),
                 .dof = std::vector<int>(num_campaigns, 0)};
  for (const auto& [key, members] : groups) {
    if (members.size() < 2) continue;
    const auto c = static_cast<std::size_t>(
        observed.campaign_of()[static_cast<std::size_t>(members.front())]);
    sum[c] += squares(members);
    pure.dof[c] += static_cast<int>(members.size()) - 1;
  }
  for (std::size_t c = 0; c < num_campaigns; ++c) {
    if (pure.dof[c] < least_dof) continue;
    pure.sigma_mm[c] = std::sqrt(sum[c] / pure.dof[c]);
  }
  return pure;
}

PureError NoLessThanRounded(const Observed& observed, PureError pure) {
  for (std::size_t c = 0; c < pure.sigma_mm.size(); ++c) {
    if (!Known(pure.sigma_mm[c])) continue;
    pure.sigma_mm[c] =
        std::max(pure.sigma_mm[c], RoundedTo_mm(observed, observed.campaigns()[c]));
  }
  return pure;
}

}  // namespace

PureError RepeatsOf(const Observed& observed, int least_dof) {
  const std::vector<bool> none(static_cast<std::size_t>(observed.num_rows()), false);
  return Pooled(
      observed, ReplicatesOf(observed, none), least_dof, [&](const auto& members) {
        return AboutMean(members, observed.residual_mm());
      });
}

PureError PureErrorOf(const Observed& observed, int least_dof) {
  return NoLessThanRounded(observed, RepeatsOf(observed, least_dof));
}

PureError PureErrorOf(const Observed& observed,
                      const Eigen::VectorXd& left_mm,
                      const std::vector<bool>& left_out,
                      int least_dof) {
  Groups groups = ReplicatesOf(observed, left_out);
  if (!observed.has_times()) {
    return NoLessThanRounded(
        observed, Pooled(observed, groups, least_dof, [&](const auto& members) {
          return AboutNextWhereItDrifts(members, left_mm);
        }));
  }
  for (auto& [key, members] : groups) {
    std::ranges::stable_sort(
        members, {}, [&](Eigen::Index i) { return observed.at(i).t_s; });
  }
  return NoLessThanRounded(
      observed, Pooled(observed, groups, least_dof, [&](const auto& members) {
        return AboutNext(members, left_mm);
      }));
}

Eigen::VectorXd GuessSigma_mm(const Observed& observed,
                              const Eigen::VectorXd& baseline_residual_mm) {
  constexpr int kEnoughReplicates = 10;
  // From each replicate to the next: what drifts between them may have a cause.
  const std::vector<bool> none(static_cast<std::size_t>(observed.num_rows()), false);
  const PureError pure =
      PureErrorOf(observed, observed.residual_mm(), none, kEnoughReplicates);
  std::vector<double> rounded_mm;
  for (const std::string& name : observed.campaigns()) {
    rounded_mm.push_back(RoundedTo_mm(observed, name));
  }
  std::vector<std::vector<double>> sizes(observed.campaigns().size());
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    sizes[static_cast<std::size_t>(observed.campaign_of()[static_cast<std::size_t>(i)])]
        .push_back(std::abs(baseline_residual_mm[i]));
  }
  Eigen::VectorXd sigma_mm(observed.num_rows());
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const auto c =
        static_cast<std::size_t>(observed.campaign_of()[static_cast<std::size_t>(i)]);
    const double stated = observed.StatedSigma_mm(i);
    double sigma = kSigmaOfMedian * Median(sizes[c]);
    if (Known(pure.sigma_mm[c])) sigma = std::min(sigma, pure.sigma_mm[c]);
    if (Known(stated)) sigma = stated;
    sigma_mm[i] = std::max({sigma, rounded_mm[c], kLeastSigma_mm});
  }
  return sigma_mm;
}

}  // namespace caltwin
