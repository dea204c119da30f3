#include "sim/measure/import/steps_between.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {

void StepsBetween::Take(const ConsoleLine& said, int line, bool is_report) {
  if (!IsCommand(said, "m92")) return;
  const auto steps = WordOf(said, 'z');
  if (!steps || *steps <= 0) return;
  // What was reported alike before was not set.
  const bool is_new = Known(set_) ? *steps != set_ : !is_report;
  before_ = is_new ? set_ : before_;
  set_ = *steps;
  if (is_new) line_ = line;
}

void StepsBetween::Tell(Imported* imported) const {
  constexpr std::size_t kFewest = 9;
  constexpr double kLeast_mm = 0.2;
  if (line_ == 0) return;
  std::vector<double> earlier_mm, later_mm;
  for (const Row& row : imported->table.rows) {
    if (row.kind != RowKind::kTouch) continue;
    (row.place.line < line_ ? earlier_mm : later_mm).push_back(row.value_mm);
  }
  if (earlier_mm.size() < kFewest || later_mm.size() < kFewest) return;
  const double shift_mm = Median(later_mm) - Median(earlier_mm);
  if (std::abs(shift_mm) < kLeast_mm) return;
  const double change = set_ / before_ - 1;
  const std::string over = Known(change) && change != 0
                               ? fmt::format(" ({:+.2f} %, over {:.0f} mm of travel)",
                                             100 * change,
                                             std::abs(shift_mm / change))
                               : "";
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "Line {} set the steps/mm of Z to {:g} between the two maps, and the "
           "heights "
           "differ by {:+.2f} mm{}: Z counts anew from where it homes, so the zero, "
           "the "
           "probe's offset and the map are those of another machine. Neither bed nor "
           "probe changed. Home, find the zero anew and probe again before printing; "
           "and a screw's steps follow from its lead and the motor (200 x 16 / 8 mm = "
           "400), not from a print",
           line_,
           set_,
           shift_mm,
           over),
       .fact = "offset",
       .axis = "z",
       .word = "zero",
       .figures = {{"change_um", UmFromMm(shift_mm)}}});
}

}  // namespace caltwin
