#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tests/blind/vector3.h"

namespace blind {

inline constexpr double kMmPerUm = 1e-3;

/// One linear axis as drawn: what its machine file says.
struct AxisDrawing {
  double min_mm = 0, max_mm = 300;
  bool is_belt = false;
  double lead_mm = 4;  ///< Of a screw, or travel per turn of a pulley.
  double full_steps_per_rev = 200;
  double microsteps = 16;
  double friction_n = 8;

  double Mid_mm() const { return 0.5 * (min_mm + max_mm); }
  double Half_mm() const { return 0.5 * (max_mm - min_mm); }
  double StepsPerMm() const { return full_steps_per_rev * microsteps / lead_mm; }
  /// Position scaled to -1 .. 1 over the travel.
  double Scaled(double q_mm) const { return (q_mm - Mid_mm()) / Half_mm(); }
};

/// The machine as drawn, and the tip radius that its firmware believes.
struct Drawing {
  std::array<AxisDrawing, 3> axes{};
  double tip_radius_cfg_mm = 1;

  const AxisDrawing& axis(int index) const {
    return axes[static_cast<std::size_t>(index)];
  }
};

class ModelText;

enum class Kind { kPosition, kTouch, kRadial };

/// Temperatures of a row [deg C].
enum Thermometer { kScrew, kFrame, kBed, kChamber, kAmbient, kThermometers };

/// The circumstances of one reading: what an error may depend on.
struct Instant {
  Kind kind = Kind::kPosition;
  double t_s = 0;
  int home = 0;  ///< Homing session, and when it began.
  double homed_t_s = 0;
  Vector3 q_mm{};          ///< Commanded position of the axes.
  Vector3 dir{};           ///< Sense of each axis's last motion, +1 or -1.
  Vector3 since_rev_mm{};  ///< Travel since it last turned round.
  double feed_mm_s = 1;
  double load_n = 8;
  Vector3 n{};             ///< Outward normal, or direction of reading.
  double spindle_rad = 0;  ///< Counter-clockwise from above.
  Vector3 offset_mm{};     ///< Tip = commanded + offset.
  std::string artefact{};  ///< Word before the dot of `feature`.
  double turn_rad = 0;     ///< Of the artefact about the middle of the travel.
  Vector3 point_mm{};      ///< Where the surface is touched, machine axes.
  bool on_circle = false;  ///< Moving along a ball-bar's circle:
  Vector3 center_mm{};
  double radius_mm = 0;
  double sense = 1;  ///< +1 counter-clockwise.
};

/// One thing wrong with the machine, the probe, the artefact or the room. Each function
/// is optional and returns millimetres for size 1; the size multiplies them.
struct Defect {
  std::string cause{}, axis{};
  /// A parameter of the truth: `value` times size if it grows with the size.
  struct Parameter {
    std::string name{};
    double value = 0;
    bool grows = true;
  };
  std::vector<Parameter> parameters{};
  double size = 1;

  /// Actual minus commanded tip position.
  std::function<Vector3(const Instant&)> motion{};
  /// Growth of an axis's whole gap at commanded position q [mm].
  std::function<double(int axis, double q_mm)> gap{};
  /// Growth of the way from contact to trigger.
  std::function<double(const Instant&)> pretravel{};
  /// The surface stands further out along n by this.
  std::function<double(const Instant&)> surface{};
  /// Added to the reading itself (a glitch of the sensor).
  std::function<double(const Instant&)> reading{};
  /// Growth of the tip's true radius.
  double tip_radius_mm = 0;
  /// How a model of MuJoCo gets it, as text; empty: it cannot.
  std::function<void(double size, ModelText* model)> build{};
};

}  // namespace blind
