// Whether rows that say how far an axis went since its last reversal were commanded to
// go that far.

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Moves of one axis in one campaign: the command's change over the travel's, wherever
// the travel since the reversal grew from one row to the next.
struct Moves {
  const Row* first = nullptr;
  int all = 0;
  int as_said = 0;  ///< The command moved as far.
  int still = 0;    ///< It did not move.
  int in_inches = 0;
};

void Count(const Row& before, const Row& now, std::size_t axis, Moves* moves) {
  constexpr double kLeast_mm = 0.5;
  constexpr double kNear = 0.05;
  const double travel_mm = now.since_rev_mm[axis] - before.since_rev_mm[axis];
  if (!(travel_mm > kLeast_mm)) return;
  const double moved_mm = std::abs(now.cmd_mm[axis] - before.cmd_mm[axis]);
  if (!std::isfinite(moved_mm)) return;
  const auto is_about = [&](double ratio) {
    return std::abs(moved_mm - ratio * travel_mm) <= kNear * ratio * travel_mm;
  };
  if (moves->first == nullptr) moves->first = &now;
  ++moves->all;
  moves->as_said += is_about(1) ? 1 : 0;
  moves->still += moved_mm < kNear * kLeast_mm ? 1 : 0;
  moves->in_inches += is_about(1 / MmFromInch(1.0)) ? 1 : 0;
}

// Every touch comes from outside and goes back: what it travelled along its normal
// begins anew each time, however alike the senses are.
bool TurnsRound(const Row& row, std::size_t axis) {
  constexpr double kAlong = 0.1;
  return row.kind == RowKind::kTouch && std::abs(row.n[axis]) > kAlong;
}

void DoubtCampaign(const Moves& moves, std::size_t axis, std::vector<Doubt>* doubts) {
  constexpr int kFewest = 6;
  constexpr double kMost = 0.7;
  if (moves.all < kFewest) return;
  const auto most = static_cast<int>(kMost * moves.all);
  if (moves.in_inches <= most && moves.still <= most) return;
  const char letter = "xyz"[axis];
  const bool is_inch = moves.in_inches > most;
  doubts->push_back(
      {.kind = is_inch ? "position_unit" : "moves_contradict",
       .message =
           is_inch
               ? fmt::format("campaign {}: cmd_{}_mm changes by an inch's part (1 / "
                             "25.4) of the travel that since_rev_{}_mm says",
                             moves.first->campaign,
                             letter,
                             letter)
               : fmt::format("campaign {}: {} is said to travel (since_rev_{}_mm) in "
                             "{} rows in which cmd_{}_mm stands still",
                             moves.first->campaign,
                             letter,
                             letter,
                             moves.still,
                             letter),
       .hint = is_inch
                   ? fmt::format("cmd_{}_mm is in mm, and here it is in inches", letter)
                   : "two columns are exchanged, or the travel belongs to another "
                     "axis",
       .refuse = true});
}

}  // namespace

void DoubtMoves(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts) {
  std::map<std::tuple<std::string, std::size_t>, Moves> by_campaign;
  const Row* before = nullptr;
  for (const Row* row : rows) {
    const bool goes_on = before != nullptr && before->campaign == row->campaign &&
                         before->setup == row->setup;
    for (std::size_t axis = 0; goes_on && axis < 3; ++axis) {
      const double sense = row->dir[static_cast<int>(axis)];
      if (!Known(sense) || sense == 0 || sense != before->dir[static_cast<int>(axis)] ||
          TurnsRound(*row, axis)) {
        continue;
      }
      Count(*before, *row, axis, &by_campaign[{row->campaign, axis}]);
    }
    before = row;
  }
  for (const auto& [key, moves] : by_campaign)
    DoubtCampaign(moves, std::get<1>(key), doubts);
}

}  // namespace caltwin
