#include "calibration/diagnosis/stated_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/remains.h"
#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

struct Campaign {
  std::string name{};
  double scatter_mm = 0, stated_mm = 0;
};

// Those whose scatter is known and far from what is stated.
std::vector<Campaign> FarFromStated(const Observed& observed,
                                    const SearchResult& search) {
  constexpr double kEnoughDof = 6, kFar = 8;
  const std::vector<Floor> floors = FloorsOf(observed, search);
  std::vector<std::vector<double>> stated_mm(floors.size());
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double sigma_mm = observed.StatedSigma_mm(i);
    const int campaign = observed.campaign_of()[static_cast<std::size_t>(i)];
    if (!Known(sigma_mm)) continue;
    stated_mm[static_cast<std::size_t>(campaign)].push_back(sigma_mm);
  }
  std::vector<Campaign> far;
  for (std::size_t c = 0; c < floors.size(); ++c) {
    const double stated = Median(stated_mm[c]), scatter = floors[c].sigma_mm;
    const bool is_known = stated > 0 && scatter > 0 && floors[c].dof >= kEnoughDof;
    if (!is_known || std::max(stated / scatter, scatter / stated) < kFar) continue;
    far.push_back({observed.campaigns()[c], scatter, stated});
  }
  return far;
}

}  // namespace

std::string_view InchesBy(double ratio) {
  constexpr double kInch_mm = MmFromInch(1.0);
  constexpr double kAlike = 0.2;  // What a scatter of some twenty repeats tells.
  const auto is_about = [&](double times) {
    return std::abs(ratio / times - 1) < kAlike;
  };
  if (is_about(kInch_mm)) return "that is an inch: is value_mm in inches?";
  if (is_about(1 / kInch_mm)) return "that is an inch: is the uncertainty in inches?";
  if (is_about(kInch_mm / 1000)) {
    return "that is a thousandth of an inch: is value_mm in thousandths?";
  }
  return {};
}

std::string RemarkOnStatedNoise(const Observed& observed, const SearchResult& search) {
  constexpr std::size_t kMostTold = 3;
  const std::vector<Campaign> far = FarFromStated(observed, search);
  if (far.empty()) return "";
  std::string text = "Readings scatter otherwise than is stated:";
  std::vector<double> ratios;
  for (std::size_t c = 0; c < far.size(); ++c) {
    ratios.push_back(far[c].stated_mm / far[c].scatter_mm);
    if (c >= kMostTold) continue;
    text += fmt::format("{} {} by {:.3g} um (stated {:.3g})",
                        c == 0 ? "" : ",",
                        far[c].name,
                        UmFromMm(far[c].scatter_mm),
                        UmFromMm(far[c].stated_mm));
  }
  if (far.size() > kMostTold) {
    text += fmt::format(" and {} more", far.size() - kMostTold);
  }
  const std::string_view inches = InchesBy(Median(ratios));
  return text + fmt::format("; {}",
                            inches.empty() ? "the stated figures or value_mm may be in "
                                             "another unit, and so every size here"
                                           : inches);
}

}  // namespace caltwin
