#include "sim/measure/import/screw_differences.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/fields.h"

namespace caltwin {

bool ScrewDifferences::Take(const std::string& lower) {
  const auto first = NumberAfter(lower, "z2-z1=");
  const auto second = NumberAfter(lower, "z3-z2=");
  const auto third = NumberAfter(lower, "z3-z1=");
  if (!first || !second || !third) return false;
  rounds_mm_.push_back({std::abs(*first), std::abs(*second), std::abs(*third)});
  return true;
}

void ScrewDifferences::Tell(Imported* imported) const {
  constexpr std::size_t kFewest = 3;
  constexpr double kGone = 0.2, kStays = 0.8, kLeast_mm = 0.05;
  if (rounds_mm_.size() < kFewest) return;
  // Each difference's screws, and the one that is not of it.
  constexpr std::array kWithout = {3, 1, 2};
  for (std::size_t k = 0; k < kWithout.size(); ++k) {
    const auto of = [k](const std::array<double, 3>& round) {
      return round[k];
    };
    const double most_mm = std::ranges::max(rounds_mm_, {}, of)[k];
    const double last_mm = rounds_mm_.back()[k];
    double before_mm = HUGE_VAL, after_mm = HUGE_VAL;
    for (std::size_t other = 0; other < kWithout.size(); ++other) {
      if (other == k) continue;
      // Between two rounds in a row: by hand people turn a screw in between.
      before_mm = std::min(before_mm, rounds_mm_[rounds_mm_.size() - 2][other]);
      after_mm = std::min(after_mm, rounds_mm_.back()[other]);
    }
    const bool is_stuck = last_mm < kGone * most_mm && after_mm > kLeast_mm &&
                          after_mm > kStays * before_mm && last_mm < kGone * after_mm;
    if (!is_stuck) continue;
    imported->notes.push_back(
        {.kind = FileNote::Kind::kOpen,
         .what = "cause",
         .sentence = fmt::format("why screw Z{} does not follow its correction: the "
                                 "other two come to {:.2f} "
                                 "mm of each other, and it stays {:.2f} mm away, round "
                                 "after round. Send each "
                                 "motor by itself a millimetre and look: its wires, "
                                 "its driver, which driver "
                                 "the firmware has for it",
                                 kWithout[k],
                                 last_mm,
                                 after_mm)});
    return;
  }
}

}  // namespace caltwin
