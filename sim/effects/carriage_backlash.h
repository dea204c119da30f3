#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/linkage_at.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {

/// A delta's carriage with play between belt and carriage: where its rail holds it, it
/// stays behind by the gap after its motor turns back.
///
///   carriage - commanded = -dir gap / 2,  dir +1: last moved down
///
/// about the middle of the gap. Where more hangs on the carriage than its rail holds
/// (TowerLoad_n, which depends on the pose), it rests on the lower side whichever way
/// it came, as after a move up (dir = -1): then nothing is lost at a reversal, and what
/// it hangs lower by is the endstop's.
struct CarriageBacklash {
  static constexpr std::array kParameters = {
      Parameter{.name = "gap_mm",
                .unit = "mm",
                .min = 0,
                .max = 1,
                .prior = LogNormal{.median = 0.03, .factor = 2},
                .doc = "Full width of the gap."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"dir_" + std::string(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "carriage_backlash",
      .about =
          "A carriage has play against its belt: it lags behind when it turns back, "
          "where its rail holds it against the weight that hangs on it.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula =
          "carriage: -dir gap / 2 of travel, dir the sense of its motor; up "
          "(-1) wherever (carriage + share of the effector) g > rail_friction_n",
      .source = "Wheels or bushes with play, belt teeth: 0.02 to 0.1 mm.",
      .twin =
          "trigger_scatter, where the sense of approach is not known; touches after "
          "moves up and down tell.",
      .words = {.plot = "Height after moves up less height after moves down: a "
                        "constant, seen most near that tower.",
                .values = "0.02 to 0.1 mm.",
                .cause = "Loose carriage wheels, worn bushes, a belt clip that gives.",
                .effect =
                    "Seams and corners, sizes that depend on the sense of travel.",
                .action = "Adjust the eccentric nuts, preload the carriage, shorten "
                          "the belt clip."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const int tower = DriveNamed(asked.axis)->index;
    if (IsHeld(asked, tower)) {
      errors->motor_lost_motion_mm[tower] += asked.p[0];
    } else {
      errors->motor_mm[tower] += asked.p[0] / T(2);
    }
  }

 private:
  // By the rail, so that the drive has to push it down.
  template <typename T>
  static bool IsHeld(const Asked<T>& asked, int tower) {
    const LinkageAt* here = asked.at.linkage;
    if (here == nullptr) return true;
    const AxisDrawing& drawing = asked.machine.axes[static_cast<std::size_t>(tower)];
    const double rise = here->by_knob(Index(Axis::kZ), kEndstopKnob + tower);
    return TowerLoad_n(drawing, DeltaOf(asked.machine), rise) < drawing.rail_friction_n;
  }
};

}  // namespace caltwin
