#pragma once

#include <vector>

#include "tests/blind/machine.h"

namespace blind {

/// A number per row.
using Column = std::vector<double>;

/// What every diagnosis fits away before it looks for causes, as columns over the rows:
/// scale, backlash and pre-travel of each axis, the table's plane, and each setup's
/// offset and rotation about the vertical.
std::vector<Column> BaselineColumns(const Plan& plan,
                                    const std::vector<Reading>& readings);

/// Columns made orthonormal; dependent ones are dropped.
class Projector {
 public:
  explicit Projector(const std::vector<Column>& columns);
  /// What of `column` no combination of the columns can imitate.
  Column Rest(Column column) const;

 private:
  std::vector<Column> basis_{};
};

/// How large an effect is in the data [sigma of one reading].
struct Visible {
  double peak = 0;         ///< 95th percentile of the rows on which it acts.
  double sum_squares = 0;  ///< Over all rows.
  double whole_peak = 0;   ///< Largest before the baseline has taken its part.
};

/// Of a whitened effect after the baseline has taken its part.
Visible VisibleEffect(const Column& whitened_effect, const Projector& baseline);

}  // namespace blind
