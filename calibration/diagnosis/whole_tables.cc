#include "calibration/diagnosis/whole_tables.h"

#include <vector>

#include "calibration/diagnosis/evidence.h"

namespace caltwin {
namespace {

// The baseline's lines first, then the columns of all that was found.
Evidence::Fit FitTogether(const Observed& observed,
                          const SearchResult& search,
                          std::vector<Nuisance> lines,
                          const std::vector<Nuisance>& found) {
  lines.insert(lines.end(), found.begin(), found.end());
  return Evidence(observed,
                  {search.circumstances.sigma_mm, search.wander_mm2_per_s},
                  lines,
                  search.circumstances.left_out)
      .FitNuisances();
}

}  // namespace

bool IsPlace(std::string_view line) {
  return line.starts_with("placement.") || line.starts_with("bed_plane.");
}

bool IsDetermined(const Nuisance& line, double sd) {
  constexpr double kOpen_mm = 0.05;
  constexpr double kKnown = 0.5;
  return sd * line.column_mm.cwiseAbs().maxCoeff() < kOpen_mm &&
         sd < kKnown * line.prior_sd;
}

std::vector<Nuisance> LinesBesideTables(const Observed& observed,
                                        const std::vector<Candidate>& candidates,
                                        const SearchResult& search) {
  const std::vector<Nuisance>& lines = search.circumstances.nuisances;
  std::vector<Nuisance> found, named;
  bool has_table = false;
  for (const Found& one : search.found) {
    const Candidate& candidate = candidates[one.candidate];
    const auto columns = NuisancesOf(observed, candidate, one);
    found.insert(found.end(), columns.begin(), columns.end());
    has_table |= candidate.is_free();
    if (!candidate.is_free()) named.insert(named.end(), columns.begin(), columns.end());
  }
  if (!has_table) return lines;
  const Evidence::Fit beside = FitTogether(observed, search, lines, found);
  const Evidence::Fit alone = FitTogether(observed, search, lines, named);
  std::vector<Nuisance> kept;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    // Told ten times worse beside the table: what is known of it is the table's.
    constexpr double kWorse = 10;
    const bool is_lost = !IsDetermined(lines[k], beside.sds[at]) ||
                         beside.sds[at] > kWorse * alone.sds[at];
    const bool is_shared = lines[k].reported && !IsPlace(lines[k].name) && is_lost &&
                           IsDetermined(lines[k], alone.sds[at]);
    if (!is_shared) kept.push_back(lines[k]);
  }
  return kept;
}

}  // namespace caltwin
