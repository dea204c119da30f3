#pragma once

#include <string>
#include <vector>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Rows, and what explains them.
struct DeltaRecord {
  DataHeader header{};
  RowTable rows{};
};

/// Writes a delta's touches down as measured rows (`--record`): of the bed, from counts
/// of whole motor steps, by the settings in force.
class DeltaRows {
 public:
  /// @param sigma_mm  of the trigger, for the header
  /// @param record  borrowed, as `machine` is
  DeltaRows(const Machine& machine, double sigma_mm, DeltaRecord* record);

  /// Of the rows from here on: their campaign, and where the firmware has the tip from
  /// the nozzle (M851).
  void Begin(const std::string& campaign);
  void SetOffset(const Vec3<double>& probe_offset_mm) { offset_mm_ = probe_offset_mm; }
  /// @param counted_mm  travel of the carriages at the trigger
  void Add(const DeltaModel<double>& settings, const Vec3<double>& counted_mm);

 private:
  std::string IdOf(const DeltaModel<double>& settings);

  const Machine& machine_;
  DeltaRecord* record_;
  std::string campaign_{};
  Vec3<double> offset_mm_ = Vec3<double>::Zero();
  std::vector<DeltaModel<double>> seen_{};
};

}  // namespace caltwin
