#pragma once

#include "sim/base/units.h"
#include "sim/effects/carriages.h"

namespace caltwin {

/// A carriage pitches, yaws or rolls as it moves; the tip, away from its pivot, moves
/// with it (Abbe).
///
///   EBX: theta about y = slope U_x / 2,  d = theta e_y x r   [mm]
///
/// and so on: the second letter is the rotation (A about x, B about y, C about z), the
/// third the axis that moves. r goes from the carriage's pivot to the tip: for y
/// (x - mid + off_x, off_y, z - mid + off_z), for x (off_x, off_y, z - mid + off_z),
/// for z the probe's offset alone. Exact in theta. EAX is axis_twist.
struct Angular {
  static constexpr std::array<std::string_view, 8> kAxes = {
      "EBX", "ECX", "EAY", "EBY", "ECY", "EAZ", "EBZ", "ECZ"};
  static constexpr std::array<std::string_view, 3> kTripleZAxes = {"EBY", "EAZ", "EBZ"};
  static constexpr std::array kParameters = {
      Parameter{.name = "slope_urad",
                .unit = "urad",
                .min = -20000,
                .max = 20000,
                .prior = Normal{.mean = 0, .sd = 80},
                .doc = "Change of the rotation over the whole travel, right-handed "
                       "about the axis of the second letter; 0 in the middle."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  /// Where the largest lever shows it, and that lever's coordinate. Rotations whose
  /// lever is the probe's offset alone show in the axis across both.
  static Shown ShownIn(std::string_view axis) {
    if (axis == "EBX") return {.channel = "x", .covariates = {"x", "z"}};
    if (axis == "ECX") return {.channel = "y", .covariates = {"x"}};
    if (axis == "EAY") return {.channel = "y", .covariates = {"y", "z"}};
    if (axis == "EBY") return {.channel = "z", .covariates = {"x", "y"}};
    if (axis == "ECY") return {.channel = "y", .covariates = {"x", "y"}};
    if (axis == "EAZ") return {.channel = "y", .covariates = {"z"}};
    if (axis == "EBZ") return {.channel = "x", .covariates = {"z"}};
    return {.channel = "x", .covariates = {"z"}};
  }
  /// The tool against the bed: in z, by where it stands over it.
  static Shown ShownOnScrews(std::string_view axis) {
    if (axis == "EBY") return {.channel = "z", .covariates = {"x", "y"}};
    return {.channel = "z", .covariates = {axis == "EAZ" ? "y" : "x", "z"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "angular",
      .about =
          "A carriage turns as it moves (pitch, yaw or roll), and the tip, away "
          "from its guides, moves with it.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "EBX: d = theta e_y x r, theta = slope U_x / 2, r from pivot to tip",
      .source =
          "ISO 230-1, names; Abbe's principle. Machine tools 10 to 40 urad over "
          "the travel, routers on extrusions 50 to 200.",
      .twin =
          "At one height, or with one probe offset, a turn looks like wrong steps/mm, "
          "straightness or squareness. Two heights (or offsets) tell them apart: a "
          "turn grows with its lever.",
      .words = {.plot = "Scale error (or squareness) against height or arm: a line "
                        "through the height of no error.",
                .values = "Slope: 10 to 200 urad, i.e. um per metre of lever; 100 urad "
                          "at 100 mm make 10 um over the travel.",
                .cause = "Rails bent or not parallel, short carriages, a gantry driven "
                         "from one side.",
                .effect = "Parts are right at one height and wrong at another.",
                .action = "Calibrate at the height of the work, lengthen the wheel "
                          "base, straighten the rail."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn, .shown_on_screws = ShownOnScrews}};

  /// On a triple-Z printer the gantry leans, EAZ and EBZ, as the bed moves along z:
  /// about its middle, r = (x - mid, y - mid, 0).
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Axis moving = MovingAxis(asked.axis);
    const Axis about = AxisOfRotation(asked.axis[1]);
    if (asked.at.screws && moving == Axis::kZ) {
      Vec3<T> lever_mm = asked.q_mm + asked.at.probe_off_mm.template cast<T>();
      for (const Axis axis : {Axis::kX, Axis::kY}) {
        lever_mm[Index(axis)] -= asked.machine.axis(axis).mid_mm();
      }
      lever_mm[2] = T(0);
      AddRotationOf(lever_mm, asked, moving, about, RadFromUrad(asked.p[0]), errors);
      return;
    }
    AddRotation(asked, moving, about, RadFromUrad(asked.p[0]), errors);
  }
};

}  // namespace caltwin
