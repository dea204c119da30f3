#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "sim/mjcf/mjcf.h"

namespace caltwin {

struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// A compiled machine with its state, in millimetres and newtons outside.
///
/// The motors are exact: before each step the nuts get the force that puts them where
/// they are told to be one step later (dead-beat, 1e-5 um). Everything else (carriages
/// in their gaps, friction, stylus, contact) is MuJoCo's.
class World {
 public:
  /// @param hanging_n  load along -z on the vertical carriage: weight less
  /// counterbalance
  World(ModelPtr model, double hanging_n);

  double timestep_s() const;
  /// Puts the machine there, stylus at rest, forgetting what was: nuts and carriages at
  /// these positions and speeds.
  void Place(const Vec3<double>& nuts_mm,
             const Vec3<double>& carriages_mm,
             const Vec3<double>& nuts_mm_s,
             const Vec3<double>& carriages_mm_s);
  /// One time step, after which the nuts stand at `nuts_mm`.
  void Step(const Vec3<double>& nuts_mm);

  Vec3<double> Nuts_mm() const;
  Vec3<double> Carriages_mm() const;
  Vec3<double> Carriages_mm_s() const;
  /// The ball's centre relative to its rest: what opens the switch.
  Vec3<double> Deflection_mm() const;
  Vec3<double> Deflection_mm_s() const;
  /// Where the ball's centre is at rest (undeflected), machine axes.
  Vec3<double> Tip_mm() const;
  /// Least distance of the fitted stylus to anything touchable, where it is below
  /// `most_mm`; `most_mm` otherwise. MuJoCo's own geometry, not the closed form's.
  double Clearance_mm(double most_mm) const;

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  struct Slots {
    std::array<int, 3> qpos{};
    std::array<int, 3> dof{};
  };
  Slots SlotsOf(const std::string& prefix, const std::string& suffix) const;
  static Vec3<double> Read_mm(const mjtNum* values, const std::array<int, 3>& at);

  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  Slots nuts_, carriages_, stylus_;
  int stylus_geom_ = 0;  ///< Ball or disc, whichever is fitted.
  int z_body_ = 0;
  std::vector<int> touchable_{};
  double hanging_n_ = 0;
  std::array<double, 3> nut_mass_kg_{};
};

}  // namespace caltwin
