#include "calibration/diagnosis/beside_table.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "calibration/diagnosis/stories.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kFormLimit = 0.6;
constexpr double kLeastPart = 0.1;

class Table {
 public:
  Table(const Observed& observed,
        const std::vector<Candidate>& candidates,
        const Circumstances& baseline,
        const std::vector<Found>& found)
      : observed_(observed),
        candidates_(candidates),
        baseline_(baseline),
        found_(found) {}

  const Shown& shown(std::size_t i) const {
    return candidates_[found_[i].candidate].shown;
  }

  // What nothing else that was found could carry in its place [sigma]. Two that cancel
  // each other look large.
  double Carried(std::size_t i) const {
    const double more = Without({i}).chi2() - Without({}).chi2();
    return std::sqrt(std::max(0.0, more));
  }

  double Peak_mm(std::size_t i) const {
    return caltwin::Peak_mm(found_[i].variant.columns_mm * found_[i].sizes_mm);
  }

  bool CanFollow(std::size_t free, std::size_t named) const {
    const Evidence neither = Without({free, named});
    const Eigen::VectorXd effect =
        neither.Whiten(found_[named].variant.columns_mm * found_[named].sizes_mm);
    return Without({named}).Left(effect).squaredNorm() <
           (1 - kLeastPart) * neither.Left(effect).squaredNorm();
  }

 private:
  Evidence Without(std::initializer_list<std::size_t> gone) const {
    std::vector<Found> rest;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (std::ranges::find(gone, i) == gone.end()) rest.push_back(found_[i]);
    }
    std::vector<Nuisance> nuisances = baseline_.nuisances;
    const auto more = NuisancesOfAll(observed_, candidates_, rest);
    nuisances.insert(nuisances.end(), more.begin(), more.end());
    return {observed_, {baseline_.sigma_mm, 0}, nuisances, baseline_.left_out};
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const Circumstances& baseline_;
  const std::vector<Found>& found_;
};

}  // namespace

bool StandsForBoth(const Observed& observed,
                   const std::vector<Candidate>& candidates,
                   const Circumstances& baseline,
                   const std::vector<Found>& found,
                   std::size_t free,
                   std::size_t named) {
  const Table table(observed, candidates, baseline, found);
  if (!ShareRowsAndVariable(table.shown(free), table.shown(named))) return false;
  const bool is_as_tall = table.shown(free).channel == table.shown(named).channel &&
                          table.Peak_mm(free) > kFormLimit * table.Peak_mm(named);
  return (is_as_tall || table.Carried(free) > kFormLimit * table.Carried(named)) &&
         table.CanFollow(free, named);
}

}  // namespace caltwin
