// G2 and G3.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/firmware/grbl/controller.h"

namespace caltwin::grbl {
namespace {

using Plane = std::array<Eigen::Index, 3>;

Plane PlaneOf(const Modal& modal) {
  if (modal.plane == 18) return {2, 0, 1};
  if (modal.plane == 19) return {1, 2, 0};
  return {0, 1, 2};
}

/// The centre from where the arc begins [mm], of an arc that is given by its radius: of
/// the two circles through both ends the one that makes the arc the shorter, below 0
/// the longer.
std::array<double, 2> FromRadius(double x_mm,
                                 double y_mm,
                                 double radius_mm,
                                 bool is_clockwise) {
  const double chord_mm = std::hypot(x_mm, y_mm);
  if (chord_mm == 0) throw LineError(kInvalidTarget);
  const double left = 4 * radius_mm * radius_mm - chord_mm * chord_mm;
  if (left < 0) throw LineError(kArcRadius);
  double beside = -std::sqrt(left) / chord_mm;
  if (!is_clockwise) beside = -beside;
  if (radius_mm < 0) beside = -beside;
  return {0.5 * (x_mm - y_mm * beside), 0.5 * (y_mm + x_mm * beside)};
}

}  // namespace

Controller::Arc Controller::TakeArc(Block* block, const Vec3<double>& target_mm) const {
  Arc arc{.axes = PlaneOf(block->modal),
          .from_mm = At_mm(),
          .to_mm = target_mm,
          .center_mm = At_mm(),
          .is_clockwise = block->modal.motion == kClockwise};
  const Eigen::Index first = arc.axes[0], second = arc.axes[1];
  const double x_mm = arc.to_mm[first] - arc.from_mm[first];
  const double y_mm = arc.to_mm[second] - arc.from_mm[second];
  if (const auto radius_mm = TakeLength_mm(block, 'R')) {
    const auto offset_mm = FromRadius(x_mm, y_mm, *radius_mm, arc.is_clockwise);
    arc.center_mm[first] += offset_mm[0];
    arc.center_mm[second] += offset_mm[1];
    return arc;
  }
  constexpr std::string_view kLetters = "IJK";
  const auto offset = [&](Eigen::Index axis) {
    return TakeLength_mm(block, kLetters[static_cast<std::size_t>(axis)]);
  };
  const auto first_mm = offset(first), second_mm = offset(second);
  if (!first_mm && !second_mm) throw LineError(kArcOffsets);
  const double i_mm = first_mm.value_or(0), j_mm = second_mm.value_or(0);
  arc.center_mm[first] += i_mm;
  arc.center_mm[second] += j_mm;
  const double radius_mm = std::hypot(i_mm, j_mm);
  const double off_mm = std::abs(std::hypot(x_mm - i_mm, y_mm - j_mm) - radius_mm);
  constexpr double kFine_mm = 0.005, kCoarse_mm = 0.5, kPart = 0.001;
  if (off_mm > kCoarse_mm || (off_mm > kFine_mm && off_mm > kPart * radius_mm))
    throw LineError(kInvalidTarget);
  return arc;
}

double Controller::Arc::turn_rad() const {
  const Eigen::Index first = axes[0], second = axes[1];
  const Vec3<double> begin_mm = from_mm - center_mm, end_mm = to_mm - center_mm;
  constexpr double kTurn = 2 * std::numbers::pi, kNothing_rad = 5e-7;
  const double turn =
      std::atan2(begin_mm[first] * end_mm[second] - begin_mm[second] * end_mm[first],
                 begin_mm[first] * end_mm[first] + begin_mm[second] * end_mm[second]);
  if (is_clockwise && turn >= -kNothing_rad) return turn - kTurn;
  if (!is_clockwise && turn <= kNothing_rad) return turn + kTurn;
  return turn;
}

double Controller::Arc::length_mm() const {
  const Vec3<double> begin_mm = from_mm - center_mm;
  const double radius_mm = std::hypot(begin_mm[axes[0]], begin_mm[axes[1]]);
  return std::hypot(radius_mm * turn_rad(), to_mm[axes[2]] - from_mm[axes[2]]);
}

// Chords that stay within the tolerance of $12.
void Controller::MoveAlong(const Arc& arc, double feed_mm_s) {
  const Eigen::Index first = arc.axes[0], second = arc.axes[1], along = arc.axes[2];
  const Vec3<double> begin_mm = arc.from_mm - arc.center_mm;
  const double radius_mm = std::hypot(begin_mm[first], begin_mm[second]);
  const double turn_rad = arc.turn_rad();
  const double tolerance_mm = memory_.Value(kArcTolerance);
  const double under_root = tolerance_mm * (2 * radius_mm - tolerance_mm);
  constexpr int kMostChords = 20'000;
  int chords = 1;
  if (under_root > 0) {
    const double wanted = std::abs(0.5 * turn_rad * radius_mm) / std::sqrt(under_root);
    chords = std::clamp(static_cast<int>(std::min(wanted, 1e6)), 1, kMostChords);
  }
  for (int k = 1; k < chords && !needs_reset_ && !motion_.alarm(); ++k) {
    const double part = static_cast<double>(k) / chords;
    const double angle_rad = part * turn_rad;
    Vec3<double> at_mm = arc.center_mm;
    at_mm[first] +=
        begin_mm[first] * std::cos(angle_rad) - begin_mm[second] * std::sin(angle_rad);
    at_mm[second] +=
        begin_mm[first] * std::sin(angle_rad) + begin_mm[second] * std::cos(angle_rad);
    at_mm[along] = arc.from_mm[along] + part * (arc.to_mm[along] - arc.from_mm[along]);
    MoveTo(at_mm, feed_mm_s);
  }
  if (!needs_reset_ && !motion_.alarm()) MoveTo(arc.to_mm, feed_mm_s);
}

}  // namespace caltwin::grbl
