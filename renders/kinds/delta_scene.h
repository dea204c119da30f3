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

  const mjModel* model() const { return world_->model(); }
  mjData* data() const { return world_->data(); }

 private:
  std::unique_ptr<DeltaWorld> world_;
};

}  // namespace caltwin
