#pragma once

#include <array>
#include <memory>
#include <optional>

#include "sim/kinds/delta/mjcf.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/physics/world.h"

namespace caltwin {

/// A compiled delta with its state, millimetres outside. The carriages are driven
/// exactly (dead-beat), those with play through it (DeltaMjcf::AddPlay); rods, effector
/// and contact are MuJoCo's.
class DeltaWorld {
 public:
  /// Sets every rod to its length in `build`, which the model was given too.
  DeltaWorld(ModelPtr model, const DeltaBuild<double>& build);

  double timestep_s() const { return model_->opt.timestep; }
  /// Puts the machine there at these speeds, forgetting what was: commanded travels
  /// down from the endstops, and the effector as the closed chain has it. A carriage
  /// with play stands in the middle of its gap.
  void Place(const Vec3<double>& motors_mm,
             const DeltaPose<double>& pose,
             const Vec3<double>& motors_mm_s,
             const Vec3<double>& nozzle_mm_s);
  /// One time step, after which the motors stand at `motors_mm`.
  void Step(const Vec3<double>& motors_mm);

  /// Of the instant before the last Step: contacts are found at a step's beginning.
  std::optional<double> Clearance_mm() const;
  /// How far the probe is pushed in, now. nullopt: the model has none.
  std::optional<double> Deflection_mm() const;
  Vec3<double> Nozzle_mm() const;
  /// The widest gap between a carriage and its drive; 0: none has play.
  double MostPlay_mm() const;
  /// Commanded travels that the drives stand at.
  Vec3<double> Motors_mm() const;

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  Vec3<double> scale_ = Vec3<double>::Ones();            ///< Moved over commanded.
  std::array<int, 3> qpos_{}, dof_{};                    ///< Of what motors move.
  std::array<int, 3> carriage_qpos_{}, carriage_dof_{};  ///< The same without play.
  std::array<double, 3> mass_kg_{};
  int effector_qpos_ = 0, effector_dof_ = 0, effector_body_ = 0;
  int probe_qpos_ = -1;
};

/// The time step that touches with this tip to 0.02 um: a sprung one moves on before it
/// triggers, and the less time it has for that, the shorter the steps must be.
double TouchTimestep_s(const DeltaTip& tip);

/// A touch of the bed in MuJoCo: from `start_mm` above where closed-form kinematics
/// expect the contact straight down at a constant feed, until the tip meets the bed or,
/// sprung, until it is pushed in by its pre-travel.
struct DeltaTouchOptions {
  DeltaTip tip{};  ///< As the model has it.
  double feed_mm_s = 5;
  double start_mm = 0.2;
  double most_mm = 2;  ///< Beyond the expected contact, then it is no touch.
};

/// The nozzle at rest after every motor has come to these travels in its sense (+1:
/// down, -1: up; 0: it stood still), far enough to have crossed any play. nullopt: out
/// of reach.
std::optional<Vec3<double>> RestInPhysics(DeltaWorld* world,
                                          const DeltaBuild<double>& build,
                                          const Vec3<double>& motors_mm,
                                          const Vec3<double>& motor_dir);

/// The height that the firmware believes its nozzle at when that descent triggers,
/// found between two steps by MuJoCo's own distance or deflection, near `near_mm`.
/// nullopt: none, or out of reach.
std::optional<double> TouchInPhysics_mm(DeltaWorld* world,
                                        const DeltaBuild<double>& build,
                                        const DeltaBed<double>& bed,
                                        const DeltaDescent& descent,
                                        double near_mm,
                                        const DeltaTouchOptions& options = {});

}  // namespace caltwin
