#pragma once

#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "calibration/kinds/z_station/procedures.h"

namespace caltwin {

/// The hands that a descent needs.
struct FeelerHands {
  /// The gap under the nozzle, which is commanded to that height [mm].
  std::function<std::optional<double>(double height_mm)> gap_mm{};
  std::function<bool()> wipe{};  ///< The nozzle, clean; false: nobody did.
  /// Told at once why a gap is asked for again; may be empty.
  std::function<void(const std::string& why)> say{};
};
struct SwitchOffsetOptions {
  bool is_as_published = false;
  /// In force; nullopt: the one that the last CALIBRATE_Z was made with.
  std::optional<double> in_force_mm{};
  /// Over the bed, where CALIBRATE_Z probes it: a tilted bed is elsewhere beside that.
  Eigen::Vector2d at_mm{117.5, 117.5};
  int calibrations = 5;  ///< Corrected: their scatter is that of the last.
};
/// The stepwise descent: G0 Z5, 3, 1, 0.5, 0.3, 0.1 with the gap measured under the
/// nozzle at each (a feeler gauge), and the switch_offset that would have made the last
/// one right. A step is left out where it would end less than 0.02 mm over the bed;
/// where a switch_offset below 0 would be needed for the first one to be safe, it
/// begins higher.
///
/// As published it goes by the calibration that is in force, and takes ooze on the
/// nozzle's tip for switch_offset: both leave the same gap. Corrected, the nozzle is
/// wiped and calibrated (CALIBRATE_Z) first, several times: what it tells is of their
/// mean, and as uncertain as they scatter. What a bed mesh in force adds at that place
/// is taken off, and a gap that contradicts the one above it is measured once more,
/// then refused.
ProcedureResult RunSwitchOffset(ZStationClient* client,
                                const SwitchOffsetOptions& options,
                                const FeelerHands& hands);

}  // namespace caltwin
