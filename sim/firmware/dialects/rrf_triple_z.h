#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/firmware/emulated_controller.h"
#include "sim/link/gcode.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// The mechanism that a triple-Z printer's firmware drives, as little of it as it
/// feels.
class TripleZPlant {
 public:
  virtual ~TripleZPlant() = default;
  /// Raises all three screws alike until the bed meets the nozzle over (x, y), each
  /// `raised_mm` higher than the commanded height alone would have it: that commanded
  /// height of the nozzle over the bed at the trigger. nullopt: it never does.
  virtual std::optional<double> Touch(const Vec3<double>& raised_mm,
                                      double x_mm,
                                      double y_mm) = 0;
};

/// What the firmware of a triple-Z printer starts with.
struct RrfTripleZOptions {
  Pivots<double> pivots_mm{};  ///< M671 X Y: where it believes the screws to stand.
  double largest_mm = 10;      ///< M671 S: corrections above it are not made.
  double steps_per_mm = 800;   ///< M92 Z.
  double top_mm = 250;         ///< Heights of the screws with Z at 0.
  Eigen::Vector2d most_mm{235, 235};  ///< Travel of X and Y.
  double probe_mm_s = 5;              ///< M558 F.
};

/// One touch that its probe has made.
struct TripleZTouch {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double stopped_mm = 0;  ///< Height of the nozzle over the bed, as counted there.
  /// Each screw beyond what that height alone has it told, whole steps.
  Vec3<double> raised_mm = Vec3<double>::Zero();
  double steps_per_mm = 0;  ///< In force.
  double feed_mm_s = 0;
  double at_s = 0;  ///< Machine time.
  int homing = 0;   ///< G28s before it.
};

/// A controller that understands RepRapFirmware's dialect as far as a bed on three
/// screws needs it: G0 G1 G28 G30 G90 G92 M92 M114 M115 M119 M400 M584 M671.
///
/// - `M584 Z0 U1 V2 P5` gives each screw's driver an axis of its own, `M584 Z0:1:2 P3`
///   joins them again: the documented way to move drivers of one axis singly. Z, U and
///   V are heights of the nozzle over the bed at that screw: smaller raises the bed.
/// - `G30 X Y S-1` probes and answers "Stopped at height 0.123 mm".
/// - `G30 P0 X Y Z-99999` .. `G30 P3 X Y Z-99999 S3` probe points and then raise the
///   screws by LevelScrews, as M671 places them.
class RrfTripleZ final : public EmulatedController {
 public:
  /// @param plant  borrowed
  RrfTripleZ(const RrfTripleZOptions& options, TripleZPlant* plant);

  Reply Execute(std::string_view line) override;

  const Pivots<double>& pivots_mm() const { return options_.pivots_mm; }
  /// How much higher than Z alone has it each screw is told to stand, whole steps.
  Vec3<double> raised_mm() const;
  bool is_homed() const { return is_homed_; }
  /// All of them, in order.
  const std::vector<TripleZTouch>& touched() const { return touched_; }
  int touches() const { return static_cast<int>(touched_.size()); }
  double machine_time_s() const override { return time_s_; }

 private:
  Reply Obey(const GcodeCommand& command);
  Reply Home();
  Reply Move(const GcodeCommand& command);
  Reply Probe(const GcodeCommand& command);
  Reply Adjust();
  Reply SetPosition(const GcodeCommand& command);
  Reply Position() const;
  Reply SetDrivers(std::string_view line);
  Reply SetScrews(std::string_view line);

  RrfTripleZOptions options_;
  TripleZPlant* plant_;
  bool is_homed_ = false;
  bool is_split_ = false;
  std::array<bool, 3> are_placed_{true, true, true};  ///< Z U V, while split.
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();
  Vec3<double> z_mm_ = Vec3<double>::Zero();       ///< Z U V; joined: all Z.
  Vec3<double> height_mm_ = Vec3<double>::Zero();  ///< Of the screws, as counted.
  std::vector<BedTouch> points_{};                 ///< G30 P.
  std::vector<TripleZTouch> touched_{};
  double time_s_ = 0;
  int homings_ = 0;
};

}  // namespace caltwin
