#pragma once

#include <memory>

#include "sim/kinds/delta/plant.h"
#include "sim/kinds/delta/world.h"

namespace caltwin {

/// A delta's model with looks, its nozzle standing over the bed, drawn once.
class DeltaScene {
 public:
  /// @param exaggerate  how many times too large its errors are drawn; throws
  ///   InputError where rods no longer reach
  DeltaScene(const Machine& machine, const BuiltDelta& built, double exaggerate);

  /// Motors where the drawing has them for a nozzle there; false: rods do not reach.
  bool MoveTo(const Vec3<double>& nozzle_mm);

  const mjModel* model() const { return world_->model(); }
  mjData* data() const { return world_->data(); }

 private:
  DeltaModel<double> drawn_{};
  DeltaBuild<double> build_{};
  std::unique_ptr<DeltaWorld> world_;
};

}  // namespace caltwin
