#include "calibration/facts/turn.h"

#include <array>
#include <cmath>
#include <map>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

/// A command in the plane and where it went.
struct Move {
  Eigen::Vector2d told_mm = Eigen::Vector2d::Zero(), went_mm = told_mm;
  int read = 0;  ///< Axes read.
};

std::vector<Move> MovesOf(const std::vector<const Row*>& rows) {
  std::map<int, Move> by_line;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    const bool is_plane = row->kind == RowKind::kPosition && (axis == 0 || axis == 1) &&
                          Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]);
    if (!is_plane) continue;
    Move& move = by_line[row->place.line];
    move.told_mm = {row->cmd_mm[0], row->cmd_mm[1]};
    move.went_mm[axis] = row->cmd_mm[static_cast<std::size_t>(axis)] + row->value_mm;
    ++move.read;
  }
  std::vector<Move> moves;
  for (const auto& [line, move] : by_line) {
    if (move.read == 2) moves.push_back(move);
  }
  return moves;
}

std::string MirrorInWords(const Eigen::MatrixXd& a) {
  if (std::abs(a(0, 1)) > std::abs(a(0, 0))) {
    return "What is told along X goes along Y and the other way round, lengths right: "
           "the two motors or axes are exchanged (on a CoreXY: one motor turns the "
           "wrong "
           "way)";
  }
  return fmt::format(
      "The plane is mirrored, lengths right: {} runs the other way. Reverse its motor, "
      "or move its zero to the other end",
      a(0, 0) < 0 ? "X" : "Y");
}

std::string TurnInWords(double turn_deg, Fact* fact) {
  constexpr std::array kTurns_deg = {
      30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0, 180.0};
  constexpr double kNear_deg = 4;
  double near_deg = 0;
  for (const double known_deg : kTurns_deg) {
    if (std::abs(std::abs(turn_deg) - known_deg) < kNear_deg) near_deg = known_deg;
  }
  if (near_deg == 120 || near_deg == 60) fact->also = {"angle"};
  return fmt::format(
      "Everything is turned by {:.0f} degrees ({}), lengths right and nothing "
      "mirrored. "
      "{}",
      std::abs(turn_deg),
      turn_deg > 0 ? "counter-clockwise from above" : "clockwise from above",
      near_deg == 120
          ? "A third of a turn: each tower of a delta has its neighbour's angle (or "
            "motor). Give each its own; no calibration is needed for it"
      : near_deg == 90 || near_deg == 180 ? "Motors or ends of axes are exchanged in "
                                            "the configuration, not bent in the "
                                            "machine"
      : near_deg == 45
          ? "Half a right angle: one motor of a CoreXY stands still"
          : "The angle of the towers or of the part on the bed is not what "
            "the configuration says");
}

}  // namespace

void FactsOfTurn(const std::vector<const Row*>& rows, Facts* facts) {
  constexpr std::size_t kFewest = 3;
  constexpr double kLeast_deg = 15, kSizeAlike = 0.1;
  const std::vector<Move> moves = MovesOf(rows);
  if (moves.size() < kFewest) return;
  const auto num = static_cast<Eigen::Index>(moves.size());
  Eigen::MatrixXd told(num, 3), went(num, 2);
  for (Eigen::Index i = 0; i < num; ++i) {
    told.row(i) << moves[static_cast<std::size_t>(i)].told_mm.transpose(), 1;
    went.row(i) = moves[static_cast<std::size_t>(i)].went_mm.transpose();
  }
  const Eigen::MatrixXd normal = told.transpose() * told;
  if (EigenvaluesOf(normal)[0] < 1e-6 * normal.trace()) return;
  const Eigen::MatrixXd a =
      Cholesky(normal).SolveEach(told.transpose() * went).transpose();
  const double determinant = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  const double size = std::sqrt(std::abs(determinant));
  if (std::abs(size - 1) > kSizeAlike) return;
  const bool is_mirrored = determinant < 0;
  const double turn_deg =
      is_mirrored ? DegFromRad(std::atan2(a(1, 0) + a(0, 1), a(0, 0) - a(1, 1)))
                  : DegFromRad(std::atan2(a(1, 0) - a(0, 1), a(0, 0) + a(1, 1)));
  if (!is_mirrored && std::abs(turn_deg) < kLeast_deg) return;
  Fact fact{.id = "turn",
            .word = is_mirrored ? "mirror" : "turn",
            .figures = {{"angle_deg", turn_deg}, {"scale", size}},
            .is_answer = true};
  fact.sentence = is_mirrored ? MirrorInWords(a) : TurnInWords(turn_deg, &fact);
  facts->not_the_machine = {"settings", fact.sentence};
  Fact setting{.id = "settings",
               .word = is_mirrored ? "direction" : "angle",
               .sentence = fact.sentence,
               .is_answer = false};
  facts->all.push_back(std::move(fact));
  facts->all.push_back(std::move(setting));
}

}  // namespace caltwin
