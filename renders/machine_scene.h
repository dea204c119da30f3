#pragma once

#include <string>
#include <vector>

#include "renders/scene.h"
#include "sim/physics/world.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// The injected effects with every geometric error (backlash, squareness, bed tilt; all
/// that change the model but the stylus) `factor` times as far from neutral: what a
/// person could not see at its true size.
std::vector<Injected> Exaggerated(const Machine& machine,
                                  const std::vector<Injected>& effects,
                                  double factor);

/// A machine as built, with its looks and its artefacts on the table, ready to be
/// drawn.
class MachineScene {
 public:
  explicit MachineScene(const TwinConfig& config, double exaggerate = 1);

  /// Motors there, carriages trailing by half their gap as after a move in the sense
  /// + + +, stylus at rest.
  void MoveTo(const Vec3<double>& motors_mm);

  const mjModel* model() const { return world_.model(); }
  mjData* data() const { return world_.data(); }

 private:
  World world_;
  Vec3<double> lost_motion_mm_;
};

/// Where the probe shows best: a little above the first artefact, or above the middle
/// of the table where there is none.
Vec3<double> ShowPose_mm(const TwinConfig& config);

/// A picture of the machine at ShowPose_mm.
Picture MachinePicture(const TwinConfig& config,
                       double exaggerate = 1,
                       const PictureOptions& options = {});

}  // namespace caltwin
