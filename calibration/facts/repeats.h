#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "calibration/facts/fact.h"

namespace caltwin {

/// How far one reading scatters about what is measured again.
struct ReadingNoise {
  double sd_mm = kUnknown;
  double dof = 0;
  bool is_stated = false;  ///< By the person, not shown by repeats.
};

/// What repeats of one place and sense say, two sufficing: how they scatter, whether
/// they drift, fall on levels (homings), or one of them is far from the others.
struct Repeats {
  ReadingNoise noise{};                       ///< Of all rows together.
  std::map<RowKind, ReadingNoise> of_kind{};  ///< A laser scatters less than a touch.
  std::map<std::string, ReadingNoise> of_campaign{};  ///< Each has its instrument.
  std::set<std::int64_t> outliers{};                  ///< Running numbers of rows.
  /// Rows of each place at each level (homing, or where readings jumped): those alike.
  std::vector<std::vector<const Row*>> batches{};

  /// Of a campaign where it shows or states one, else of all readings of that kind,
  /// else of all.
  const ReadingNoise& NoiseOf(const std::string& campaign, RowKind kind) const {
    const auto found = of_campaign.find(campaign);
    if (found != of_campaign.end()) return found->second;
    const auto alike = of_kind.find(kind);
    return alike == of_kind.end() ? noise : alike->second;
  }
  const ReadingNoise& NoiseOf(const Row& row) const {
    return NoiseOf(row.campaign, row.kind);
  }
};

/// Adds facts to `facts`. `rows` in the order measured.
Repeats FactsOfRepeats(const std::vector<const Row*>& rows,
                       const DataHeader& header,
                       Facts* facts);

/// The stated standard uncertainty of a row: its own, else its instrument's; kUnknown.
double StatedSigma_mm(const Row& row, const DataHeader& header);

/// The step of which all readings are whole multiples, as they were read off and from
/// the first [mm]; at most 1, and 0 where all are alike.
double FinestStep_mm(const std::vector<const Row*>& rows);

}  // namespace caltwin
