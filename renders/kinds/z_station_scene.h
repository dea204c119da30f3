#pragma once

#include <memory>

#include "sim/kinds/z_station/world.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// A nozzle's station with looks (models/z_station/scene.xml), drawn once: head with
/// nozzle and probe, endstop switch, print surface.
class ZStationScene {
 public:
  /// @param exaggerate  how many times too far the parts stand off their drawing
  ZStationScene(const ZStationDrawing& drawing,
                const ZStationBuild& build,
                double exaggerate);

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  int BodyOf(const char* name) const;
  void Place(const char* name, const Vec3<double>& at_mm);

  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
};

}  // namespace caltwin
