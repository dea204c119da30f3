#pragma once

#include <span>
#include <string>

#include "sim/firmware/kinds/z_station/klipper.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A feeler gauge's reading under the nozzle, where it stands.
struct FeelerReading {
  double height_mm = 0;  ///< Commanded, by a bed mesh in force too.
  double gap_mm = 0;     ///< In whole leaves of 0.01 mm.
};

/// Rows of a nozzle's calibration (`--record`): every touch as its firmware counted it
/// less where that is drawn, and the gaps of the stepwise descent. Rows of one step of
/// a scenario are one campaign, of one G28 one `home`; they belong to the machine
/// z_station, whatever the scenario's machine is.
class ZStationRecord {
 public:
  /// @param sigma_mm  of the switches, as stated
  ZStationRecord(const ZCalibrationConfig& config, double sigma_mm);

  /// `is_wiped`: the nozzle was, before them; so for a gap.
  void AddTouches(const std::string& campaign,
                  std::span<const ZTouched> touches,
                  bool is_wiped);
  /// A feeler gauge's reading with the nozzle commanded to `gcode_mm`.
  void AddGap(const std::string& campaign,
              const ZCircumstances& when,
              const FeelerReading& read,
              bool is_wiped);

  /// From now on this switch_offset is in force.
  void SetSwitchOffset_mm(double value);

  const DataHeader& header() const { return header_; }
  const RowTable& rows() const { return rows_; }

 private:
  Row RowOf(const std::string& campaign,
            ZReading reading,
            const ZCircumstances& when,
            double nominal_mm) const;

  double position_endstop_mm_;
  ZStationDrawing drawing_{};
  std::string settings_{};  ///< Id of those in force.
  DataHeader header_{};
  RowTable rows_{};
};

}  // namespace caltwin
