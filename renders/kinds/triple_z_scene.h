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

  /// The nozzle there, z over where the bed is drawn level.
  void MoveTo(const Vec3<double>& tip_mm);

  const mjModel* model() const { return world_->model(); }
  mjData* data() const { return world_->data(); }

 private:
  double top_mm_ = 0;
  Vec3<double> tilt_mm_ = Vec3<double>::Zero();  ///< Of each screw, enlarged.
  std::unique_ptr<TripleZWorld> world_;
};

}  // namespace caltwin
