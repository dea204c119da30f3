#pragma once

#include <memory>
#include <vector>

#include "sim/kinds/triple_z/plant.h"
#include "sim/kinds/triple_z/world.h"

namespace caltwin {

/// A triple-Z printer's model with looks, its nozzle standing over the bed, drawn once.
class TripleZScene {
 public:
  /// @param exaggerate  how many times too far its bed is tilted and its screws stand
  ///   off where they are drawn
  TripleZScene(const BuiltTripleZ& built, double exaggerate);

  const mjModel* model() const { return world_->model(); }
  mjData* data() const { return world_->data(); }

 private:
  std::unique_ptr<TripleZWorld> world_;
};

}  // namespace caltwin
