#pragma once

#include <functional>
#include <string>

#include "sim/firmware/dialects/marlin_delta.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Rows, and what explains them.
struct DeltaRecord {
  DataHeader header{};
  RowTable rows{};
};

/// A delta's plant that writes down every touch as a measured row (`--record`): of the
/// bed, from counts of whole motor steps, by the settings in force.
class RecordingDeltaPlant : public DeltaPlant {
 public:
  /// @param plant  touched in its place; borrowed, as `record` is
  /// @param sigma_mm  of the trigger, for the header
  RecordingDeltaPlant(DeltaPlant* plant,
                      const Machine& machine,
                      double sigma_mm,
                      DeltaRecord* record);

  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm) override;

  /// Of the rows from here on: their campaign, the id of settings not seen yet, where
  /// the firmware has the tip from the nozzle (M851), and the time.
  void Begin(const std::string& campaign);
  void SetOffset(const Vec3<double>& probe_offset_mm) { offset_mm_ = probe_offset_mm; }

 private:
  std::string IdOf(const DeltaModel<double>& settings);

  DeltaPlant* plant_;
  const Machine& machine_;
  DeltaRecord* record_;
  std::string campaign_{};
  Vec3<double> offset_mm_ = Vec3<double>::Zero();
  std::vector<DeltaModel<double>> seen_{};
};

}  // namespace caltwin
