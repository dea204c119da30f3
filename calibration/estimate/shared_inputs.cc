#include "calibration/estimate/shared_inputs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"

namespace caltwin {
namespace {

// What each root adds to a result, signed; a root is nobody's estimate.
using Roots = std::map<std::string, double>;

double Covariance(const Roots& a, const Roots& b) {
  double sum = 0;
  for (const auto& [root, part] : a) {
    const auto other = b.find(root);
    if (other != b.end()) sum += part * other->second;
  }
  return sum;
}

// Results taken back to their roots, in whatever order they are given. Of two that
// stand on each other, measured in turns, the one asked for is taken back and the other
// left as it is.
class RootFinder {
 public:
  explicit RootFinder(std::span<const Budgeted> results) {
    for (const Budgeted& result : results) budgets_[result.name] = &result.budget;
  }

  Roots Of(const std::string& name) {
    asked_.insert(name);
    Roots roots;
    for (std::size_t line = 0; line < budgets_.at(name)->size(); ++line) {
      const Contribution& input = (*budgets_.at(name))[line];
      const std::string own = fmt::format("{} {}", name, line);
      AddTo(&roots, input.source.empty() ? own : input.source, input.sense * input.u);
    }
    asked_.erase(name);
    return roots;
  }

 private:
  void AddTo(Roots* roots, const std::string& source, double part) {
    if (!budgets_.contains(source) || asked_.contains(source)) {
      (*roots)[source] += part;
      return;
    }
    const Roots known = Of(source);
    const double u = std::sqrt(Covariance(known, known));
    if (!(u > 0)) return;
    for (const auto& [root, of_source] : known) {
      (*roots)[root] += part * of_source / u;
    }
  }

  std::map<std::string, const std::vector<Contribution>*> budgets_{};
  std::set<std::string> asked_{};
};

std::optional<double> ToldByFit(std::span<const Correlations> fits,
                                const std::string& a,
                                const std::string& b) {
  for (const Correlations& fit : fits) {
    const auto first = std::ranges::find(fit.names, a);
    const auto second = std::ranges::find(fit.names, b);
    if (first == fit.names.end() || second == fit.names.end()) continue;
    return fit.matrix(first - fit.names.begin(), second - fit.names.begin());
  }
  return std::nullopt;
}

void TakeFits(std::span<const Correlations> fits, Correlations* together) {
  const std::vector<std::string>& names = together->names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < names.size(); ++j) {
      if (i == j) continue;
      const auto told = ToldByFit(fits, names[i], names[j]);
      if (!told) continue;
      together->matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          *told;
    }
  }
}

}  // namespace

Correlations SharedCorrelations(std::span<const Budgeted> results,
                                std::span<const Correlations> fits) {
  RootFinder finder(results);
  std::vector<std::string> names;
  std::vector<Roots> roots;
  for (const Budgeted& result : results) {
    if (!(CombinedU(result.budget) > 0)) continue;
    roots.push_back(finder.Of(result.name));
    names.push_back(result.name);
  }
  Eigen::MatrixXd covariance(std::ssize(names), std::ssize(names));
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < names.size(); ++j) {
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          Covariance(roots[i], roots[j]);
    }
  }
  std::vector<Eigen::Index> sharing;
  std::vector<std::string> sharing_names;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if ((covariance.row(i).array() != 0).count() < 2) continue;
    sharing.push_back(i);
    sharing_names.push_back(names[static_cast<std::size_t>(i)]);
  }
  const Eigen::MatrixXd shared = covariance(sharing, sharing);
  Correlations together = CorrelationsOf("shared inputs", sharing_names, shared);
  TakeFits(fits, &together);
  return together;
}

std::vector<Correlations> AllCorrelations(std::span<const Budgeted> results,
                                          std::vector<Correlations> fits) {
  Correlations shared = SharedCorrelations(results, fits);
  if (!shared.names.empty()) fits.push_back(std::move(shared));
  return fits;
}

}  // namespace caltwin
