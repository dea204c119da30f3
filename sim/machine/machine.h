#pragma once

#include <any>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/yaml.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// Which end of its travel an axis homes to.
enum class HomeEnd { kMin, kMax };

/// One axis as drawn (nominal).
struct AxisDrawing {
  double min_mm = 0;
  double max_mm = 300;
  HomeEnd home = HomeEnd::kMin;
  double lead_mm = 4;    ///< Travel per motor turn; of a belt: the pulley's.
  bool is_belt = false;  ///< Given as pulley_mm_per_rev instead of lead_mm.
  double full_steps_per_rev = 200;
  double microsteps = 16;
  double max_feed_mm_s = 100;
  double acceleration_mm_s2 = 500;
  double moving_mass_kg = 6;
  double rail_friction_n = 8;
  /// Upward force that carries the moving mass; vertical axis only. Where it leaves
  /// more than the rail friction hanging, the weight keeps the gap shut (no lost
  /// motion).
  double counterbalance_n = 0;

  double home_mm() const { return home == HomeEnd::kMin ? min_mm : max_mm; }
  double mid_mm() const { return (min_mm + max_mm) / 2; }
  double travel_mm() const { return max_mm - min_mm; }
  /// Microsteps per mm by the drawing: what `settings.steps_per_mm` ought to be.
  double steps_per_mm() const { return full_steps_per_rev * microsteps / lead_mm; }
};

inline constexpr double kGravity_m_s2 = 9.81;

/// Whether the load hanging on `drawing` [N], its weight less the counterbalance,
/// exceeds the rail friction, so that it, not the last direction, decides on which side
/// of its gap the carriage rests. Only the vertical axis of a cartesian machine can.
bool WeightKeepsGapShut(Axis axis, const AxisDrawing& drawing);

/// The touch probe as drawn.
struct ProbeDrawing {
  double tip_radius_mm = 1.0;
  double pretravel_mm =
      0.02;  ///< Deflection at the trigger, any direction; a delta's nozzle: none.
  double hysteresis_mm =
      0.002;  ///< Deflection lost before the release, below pretravel.
  std::vector<double> speeds_mm_s = {5, 1};  ///< Approach, then measuring touch.
  double overtravel_mm = 3;  ///< Deflection at which the stylus is bent: an alarm.
  double stiffness_n_per_mm = 15;  ///< Spring of the stylus, alike in all directions.
  double disc_radius_mm = 6;       ///< Of the disc stylus that reaches under a ledge.
};

/// What the firmware believes. Calibration moves it towards what is built.
struct Settings {
  std::array<double, 3> steps_per_mm{};
  std::array<double, 3> backlash_mm{};
  std::array<double, 3> probe_deflection_mm{};
  double tip_radius_mm = 1.0;
};

class MachineKind;
/// The kind whose axes are its drives: a gantry, a mill.
const MachineKind* CartesianKind();

/// A machine file: its drawing and the settings it starts with.
struct Machine {
  std::string name{};
  std::filesystem::path file{};  ///< Where it was read from; empty if made in code.
  const MachineKind* kind = CartesianKind();  ///< `kinematics:`; never null.
  std::filesystem::path model{};  ///< MJCF, resolved; empty: a generic one is built.
  std::array<AxisDrawing, 3> axes{};  ///< x y z, or the kind's own three.
  /// What only machines of its kind have in their drawing: a DeltaDrawing, say. Each
  /// kind's drawing.h has the function that takes it out.
  std::any own{};
  ProbeDrawing probe{};
  Settings settings{};

  const AxisDrawing& axis(Axis a) const { return axes[Index(a)]; }
  /// Null where it is of another kind.
  template <typename Drawing>
  const Drawing* Own() const {
    return std::any_cast<Drawing>(&own);
  }
  template <typename Drawing>
  Drawing* Own() {
    return std::any_cast<Drawing>(&own);
  }
};

/// Microsteps per mm of each tower, as its firmware counts.
std::array<double, 3> TowerStepsPerMm(const Machine& machine);

/// Reads and checks a machine file; throws InputError with every fault.
/// `settings` keys left out are as drawn (steps per mm from the lead, 0 backlash and
/// deflection, the probe's radius).
Machine ReadMachine(const std::filesystem::path& file);
Machine ReadMachine(YamlMap* map);

/// Finds what a scenario means by `machine: NAME`: a path (relative to `folder`), or a
/// name in ./models, then in the models the binary came with. Throws InputError at
/// `place` naming what was looked for.
std::filesystem::path FindMachine(const std::string& name_or_path,
                                  const std::filesystem::path& folder,
                                  const Place& place);

/// Reads `settings:` of a machine, scenario or truth file over `settings` in place:
/// maps by drive or, of the probe, by axis; `tip_radius_mm` a number.
void ReadSettings(YamlMap* map, const MachineKind& kind, Settings* settings);

/// Where the models, scenarios and documents lie that the binary came with: the folder
/// in CALTWIN_SHARE, else beside the binary (../share/caltwin), else the source tree.
std::filesystem::path ShareFolder();

}  // namespace caltwin
