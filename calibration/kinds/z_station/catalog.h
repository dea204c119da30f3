#pragma once

#include <functional>
#include <optional>
#include <span>

#include "calibration/kinds/z_station/switch_offset.h"
#include "calibration/procedures/catalog.h"

namespace caltwin {

/// What stands around a nozzle's station beside its wire, put on the bench
/// (Bench::kept) by whoever leads the procedures. Pointers are borrowed.
struct ZStationDesk {
  ZStationClient* client = nullptr;  ///< Hears all that the controller is told.
  FeelerHands hands{};
  /// printer.cfg's switch_offset; nullopt: nobody says.
  std::optional<double> switch_offset_mm{};
  Eigen::Vector2d bed_at_mm{117.5, 117.5};  ///< Where CALIBRATE_Z probes the bed.
  /// Writes switch_offset into printer.cfg and restarts; false: it does not take that
  /// one. Empty: nobody can, so it is said what to write.
  std::function<bool(double switch_offset_mm)> write{};
  /// The G-code offset of before the first procedure, which is put back in the end
  /// unless a new one stays; nullopt: nobody wants it back.
  std::optional<double> offset_before_mm{};
  bool stays = false;  ///< The new offset is kept.
};

/// The procedures of a nozzle's height.
std::span<const Procedure> ZStationProcedures();

}  // namespace caltwin
