#include "calibration/diagnosis/nuisance_list.h"

#include <algorithm>

#include "sim/machine/axis.h"

namespace caltwin {
void NuisanceList::Add(const std::string& name,
                       const std::string& unit,
                       double prior_sd,
                       const OfRow& of_row,
                       double offset,
                       bool reported) {
  Eigen::VectorXd column(observed_.num_rows());
  for (Eigen::Index i = 0; i < column.size(); ++i) column[i] = of_row(i);
  if (column.cwiseAbs().maxCoeff() == 0) return;
  nuisances_.push_back({name, unit, column, prior_sd, offset, reported});
}

std::vector<std::string> HomesOf(const Observed& o, bool only_touches) {
  std::vector<std::string> homes;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    if (only_touches && o.at(i).kind != RowKind::kTouch) continue;
    const std::string& home = o.row(i).home;
    if (std::ranges::find(homes, home) == homes.end()) homes.push_back(home);
  }
  return homes;
}

void AddFrameOfTracker(const Observed& o, NuisanceList* list) {
  constexpr double kTurnSd_mrad = 10;
  std::vector<bool> is_read(static_cast<std::size_t>(o.num_rows()));
  Vec3<double> middle_mm = Vec3<double>::Zero();
  int count = 0;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const auto campaign = o.header().campaigns.find(o.row(i).campaign);
    if (campaign == o.header().campaigns.end()) continue;
    const auto instrument = o.header().instruments.find(campaign->second.instrument);
    if (instrument == o.header().instruments.end()) continue;
    if (o.at(i).kind != RowKind::kPosition || instrument->second.kind != "tracker") {
      continue;
    }
    is_read[static_cast<std::size_t>(i)] = true;
    middle_mm += o.at(i).q_mm;
    ++count;
  }
  if (count == 0) return;
  middle_mm /= count;
  for (const Axis about : kAxes) {
    list->Add(
        "tracker_frame." + Name(about), "mrad", kTurnSd_mrad, [&](Eigen::Index row) {
          if (!is_read[static_cast<std::size_t>(row)]) return 0.0;
          const Vec3<double> from_mm = o.at(row).q_mm - middle_mm;
          return Unit(about).cross(from_mm).dot(o.at(row).n) * 1e-3;
        });
  }
}

}  // namespace caltwin
