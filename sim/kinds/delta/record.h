#pragma once

#include <optional>
#include <string>

#include "sim/firmware/dialects/marlin_delta.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/kinds/delta_rows.h"

namespace caltwin {

/// A delta's plant that writes down every touch as a measured row.
class RecordingDeltaPlant : public DeltaPlant {
 public:
  /// @param plant  touched in its place; borrowed, as `machine` and `record` are
  /// @param sigma_mm  of the trigger, for the header
  RecordingDeltaPlant(DeltaPlant* plant,
                      const Machine& machine,
                      double sigma_mm,
                      DeltaRecord* record)
      : plant_(plant), rows_(machine, sigma_mm, record) {}

  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm) override {
    const auto counted_mm = plant_->Touch(settings, x_mm, y_mm);
    if (counted_mm) rows_.Add(settings, *counted_mm);
    return counted_mm;
  }

  void Begin(const std::string& campaign) { rows_.Begin(campaign); }
  void SetOffset(const Vec3<double>& probe_offset_mm) {
    rows_.SetOffset(probe_offset_mm);
  }

 private:
  DeltaPlant* plant_;
  DeltaRows rows_;
};

}  // namespace caltwin
