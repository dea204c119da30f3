#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/groups.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

// Whether the second of two groups is larger than the first beyond all doubt.
bool AreApart(const Average& one, const Average& other, double least_mm) {
  constexpr double kSure = 6, kFewest = 3;
  const double sd_mm = std::max(one.sd, other.sd);
  return one.num >= kFewest && other.num >= kFewest &&
         std::abs(other.mean - one.mean) > std::max(least_mm, kSure * sd_mm);
}

void Tell(const std::string& sentence, Facts* facts) {
  if (facts->not_the_machine.reason.empty())
    facts->not_the_machine = {"firmware", sentence};
}

// Moves that are longer by one amount whenever another axis moved before, though none
// turned round.
void AddChangeOfAxis(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 0.01;
  std::vector<double> same_mm, other_mm;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const int axis = AxisAlong(*rows[i]), before = AxisAlong(*rows[i - 1]);
    if (rows[i]->kind != RowKind::kPosition || rows[i]->flag != kMoveFlag || axis < 0 ||
        before < 0) {
      return;
    }
    const double sense = rows[i]->dir[static_cast<std::size_t>(axis)];
    if (!Known(sense) || sense < 0) return;
    (axis == before ? same_mm : other_mm).push_back(rows[i]->value_mm);
  }
  const Average same = AverageOf(same_mm), other = AverageOf(other_mm);
  if (!AreApart(same, other, kLeast_mm)) return;
  const double more_mm = other.mean - same.mean;
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "scale" || fact.id == "known_ratio" ||
           fact.id == "repeatability" || fact.id == "jump" ||
           fact.id == "homing_scatter" || fact.id == "outliers";
  });
  facts->all.push_back(
      {.id = "offset",
       .word = "change_of_axis",
       .figures = {{"change_um",
                    UmFromMm(more_mm),
                    UmFromMm(std::hypot(same.sd / std::sqrt(same.num),
                                        other.sd / std::sqrt(other.num)))}},
       .sentence = fmt::format(
           "A move after one of another axis is {:.3f} mm {} than one after a move of "
           "the "
           "same axis, though no axis turned round: the firmware adds that amount at a "
           "change of axis (its backlash compensation). Set the compensation to 0 till "
           "it "
           "is mended, then measure the true gap; the scale is right",
           std::abs(more_mm),
           more_mm > 0 ? "longer" : "shorter"),
       .is_answer = true});
  Tell(facts->all.back().sentence, facts);
}

// One place that moves by the same amount after each of some event, and not without.
void AddEvents(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 0.005;
  std::vector<double> with_mm, without_mm;
  std::string event;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step_mm = rows[i]->value_mm - rows[i - 1]->value_mm;
    const bool is_after = rows[i]->flag.starts_with(kAfterFlag);
    if (is_after) event = rows[i]->flag.substr(6);
    (is_after ? with_mm : without_mm).push_back(step_mm);
  }
  if (event.empty()) return;
  const Average with = AverageOf(with_mm), without = AverageOf(without_mm);
  if (!AreApart(without, with, kLeast_mm)) return;
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "drift" || fact.id == "jump" || fact.id == "repeatability" ||
           fact.id == "homing_scatter";
  });
  facts->all.push_back(
      {.id = "offset",
       .word = "event",
       .figures = {{"change_um",
                    UmFromMm(with.mean),
                    UmFromMm(with.sd) / std::sqrt(with.num)}},
       .sentence = fmt::format(
           "Each time the table says yes to what happened before, the place moves by "
           "{} "
           "and stays there; without it, by {} um. An amount that is the same each "
           "time "
           "is reckoned, not worn: the controller counts something twice (a "
           "compensation, "
           "an offset). Home after it until that is mended",
           WithSd(UmFromMm(with.mean), UmFromMm(with.sd) / std::sqrt(with.num), "um"),
           TwoDigits(std::abs(UmFromMm(without.mean)))),
       .is_answer = true});
  Tell(facts->all.back().sentence, facts);
}

}  // namespace

void FactsOfHistory(const std::vector<const Row*>& rows, Facts* facts) {
  AddChangeOfAxis(rows, facts);
  AddEvents(rows, facts);
}

}  // namespace caltwin
