#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calibration/loop/outcome.h"
#include "sim/machine/kinds/delta/mesh.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// One touch of a delta's bed by its nozzle, its height known to be `height_mm` (0 but
/// for a probe whose offset was measured).
struct DeltaTouch {
  Vec3<double> motors_mm = Vec3<double>::Zero();  ///< Commanded travel at the trigger.
  double height_mm = 0;
  double sigma_mm = 0.01;
};

/// A distance between two places of the nozzle, measured on what was printed there.
struct DeltaDistance {
  double length_mm = 0;
  Vec3<double> from_mm = Vec3<double>::Zero();  ///< Motor travels at one end.
  Vec3<double> to_mm = Vec3<double>::Zero();
  double sigma_mm = 0.05;  ///< A calliper on plastic.
};

/// The length of one rod, joint to joint, as a calliper reads it.
struct DeltaRodLength {
  int rod = 0;  ///< As RodName counts.
  double length_mm = 0;
  double sigma_mm = 0.02;
};

/// A person with a calliper. Without functions there is none.
struct DeltaCalliper {
  /// The length of a rod. nullopt: nobody read it.
  std::function<std::optional<double>(int rod)> rod_mm{};
  /// The distance of two features of a print, drawn where the nozzle stood with the
  /// motors at these travels. nullopt: the machine does not reach there, or nobody
  /// read.
  std::function<std::optional<double>(const Vec3<double>& from_mm,
                                      const Vec3<double>& to_mm)>
      between_mm{};
  double sigma_mm = 0.02;  ///< Of one reading.
};

/// The only door of a delta's calibration: touches the bed on the way straight down at
/// (x, y) as `settings` say, and tells the motors' travels at the trigger. nullopt: out
/// of reach.
using DeltaProbe = std::function<std::optional<Vec3<double>>(
    const DeltaModel<double>& settings, double x_mm, double y_mm)>;

/// What a calibration of a delta ends with.
struct DeltaOutcome {
  DeltaModel<double> settings{};
  int touches = 0;
  bool is_done = false;  ///< It says that it has succeeded.
  double said_mm = 0;    ///< The deviation that it reports as its own.
  double tilt_x = 0;     ///< Of the bed, where the engine fits it (dz/dx).
  double tilt_y = 0;
  std::vector<Estimate>
      estimates{};  ///< Of settings, where their uncertainty is known.
  std::vector<Correlations> correlations{};
  DeltaMesh mesh{};                     ///< Where the procedure makes one.
  std::vector<std::string> messages{};  ///< What the firmware would print.
};

}  // namespace caltwin
