#include "calibration/diagnosis/nuisance_list.h"

#include <algorithm>

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

}  // namespace caltwin
