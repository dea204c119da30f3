#include "calibration/diagnosis/fit_tables.h"

#include <algorithm>
#include <utility>

#include "calibration/diagnosis/whole_tables.h"
#include "sim/base/dense.h"

namespace caltwin {
namespace {

// Columns of where things lie that these rows leave open.
Eigen::MatrixXd OpenPlaces(const std::vector<Nuisance>& lines,
                           const Eigen::VectorXd& sds) {
  std::vector<Eigen::VectorXd> columns;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const bool is_open = lines[k].reported && IsPlace(lines[k].name) &&
                         !IsDetermined(lines[k], sds[static_cast<Eigen::Index>(k)]);
    if (is_open) columns.push_back(lines[k].column_mm);
  }
  Eigen::MatrixXd places(columns.empty() ? 0 : columns[0].size(),
                         static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    places.col(static_cast<Eigen::Index>(k)) = columns[k];
  }
  return places;
}

// The sizes of a table less what a plate that leans otherwise makes of it: rows that do
// not tell how it leans give that to neither, and a table has no slope by itself.
Eigen::VectorXd WithoutPlaces(const Eigen::MatrixXd& columns_mm,
                              const Eigen::VectorXd& sizes_mm,
                              const Eigen::MatrixXd& places) {
  if (places.cols() == 0) return sizes_mm;
  const Eigen::VectorXd table_mm = columns_mm * sizes_mm;
  const Eigen::VectorXd leans_mm = places * LeastSquares(places, table_mm);
  return LeastSquares(columns_mm, table_mm - leans_mm);
}

Eigen::MatrixXd EachWithoutPlaces(const Eigen::MatrixXd& columns_mm,
                                  Eigen::MatrixXd half_mm,
                                  const Eigen::MatrixXd& places) {
  for (auto column : half_mm.colwise()) {
    column = WithoutPlaces(columns_mm, column, places);
  }
  return half_mm;
}

}  // namespace

void FitTables(const Observed& observed,
               const std::vector<Candidate>& candidates,
               const SearchResult& search,
               std::vector<Refined>* refined) {
  constexpr double kFree = 30;  // Times what was fitted.
  std::vector<Nuisance> all = LinesBesideTables(observed, candidates, search);
  std::vector<std::pair<std::size_t, std::size_t>> tables;  // Finding, first column.
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Found& found = search.found[i];
    const Candidate& candidate = candidates[found.candidate];
    const Refined& named = (*refined)[i];
    if (candidate.is_free()) {
      tables.emplace_back(i, all.size());
      const auto more = NuisancesOf(observed, candidate, found);
      all.insert(all.end(), more.begin(), more.end());
    }
    for (Eigen::Index k = 0; k < named.variant.columns_mm.cols(); ++k) {
      all.push_back({.name = candidate.Name(),
                     .unit = "mm",
                     .column_mm = named.variant.columns_mm.col(k),
                     .prior_sd = kFree * std::max(named.sizes_mm.norm(), 1e-6),
                     .reported = false});
    }
  }
  if (tables.empty()) return;
  const Evidence::Fit fit =
      Evidence(observed,
               {search.circumstances.sigma_mm, search.wander_mm2_per_s},
               all,
               search.circumstances.left_out)
          .FitNuisances();
  const Eigen::MatrixXd places = OpenPlaces(all, fit.sds);
  for (const auto& [i, first] : tables) {
    const Eigen::MatrixXd& columns_mm = search.found[i].variant.columns_mm;
    const Eigen::VectorXd sizes_mm =
        fit.values.segment(static_cast<Eigen::Index>(first), columns_mm.cols());
    (*refined)[i].sizes_mm = WithoutPlaces(columns_mm, sizes_mm, places);
    (*refined)[i].half_mm = EachWithoutPlaces(
        columns_mm,
        fit.half.middleRows(static_cast<Eigen::Index>(first), columns_mm.cols()),
        places);
  }
}

}  // namespace caltwin
