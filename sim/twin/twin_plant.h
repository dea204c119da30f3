#pragma once

#include <string>
#include <vector>

#include "sim/base/rng.h"
#include "sim/firmware/plant.h"
#include "sim/twin/built.h"

namespace caltwin {

/// One trigger of the probe as it truly was: what no controller could say.
struct TrueTrigger {
  Vec3<double> motor_steps = Vec3<double>::Zero();  ///< Latency included, not rounded.
  bool is_release = false;
};

/// What both fidelities have in common: the machine as built, the chance in each
/// trigger, the limit switches' places, and a record of what truly happened.
class TwinPlant : public Plant {
 public:
  TwinPlant(Built built, std::uint64_t seed, std::uint64_t sample);

  const Built& built() const { return built_; }
  const std::vector<TrueTrigger>& triggers() const { return triggers_; }
  Vec3<double> steps() const { return steps_; }

  /// How long the machine has been running [s]; effects follow it.
  double now_s() const { return built_.now.t_s; }

  /// The operator changed what lies on the table or which stylus is fitted.
  virtual void Change(const std::vector<Artefact>& artefacts, Stylus stylus) = 0;
  /// Where the ball's centre truly is, the stylus' deflection left out.
  virtual Vec3<double> Tip_mm() = 0;

 protected:
  /// What the motors move the axes in all of it.
  Vec3<double> Travel_mm(const Segment& segment) const;
  /// Where the carriage of an axis stands.
  double Carriage_mm(Axis axis,
                     const Vec3<double>& steps,
                     const Vec3<double>& lag_mm) const;
  /// How far the carriage of `axis` is from closing (or, opening, from releasing) its
  /// switch; positive before. It closes at the home end and opens 0.05 mm off it.
  double BeforeSwitch_mm(const Watch& watch, double carriage_mm) const;
  double DrawScatter_mm();
  /// Of what is free ahead, the part that the motors may be moved without looking: the
  /// tip's path is longer than theirs, by up to 5 % for a wrong screw, by up to 80 %
  /// where steps err by 10 um within each four.
  double Caution() const { return built_.drive_effects.empty() ? 0.95 : 0.5; }
  std::string CollisionText() const;
  /// A move begins: which axes turn round, and where.
  void Begin(const Segment& segment);
  /// It has ended: time has passed, and an axis that met its switch is homed.
  void End(const Outcome& outcome, const Watch& watch);
  void Pass(double s) { built_.now.t_s += s; }
  /// Deflection at which a move collides: the overtravel, or a little more than now for
  /// a machine that has to get out of a collision.
  double AllowedDeflection_mm(double now_mm) const;

  Built built_;
  Vec3<double> steps_ = Vec3<double>::Zero();  ///< Where the motors stand.
  double scatter_mm_ = 0;                      ///< Of the trigger now waited for.
  std::vector<TrueTrigger> triggers_{};

 private:
  Rng scatter_rng_;
  std::string home_{};  ///< Name of the homing session, which built_.now borrows.
  int homings_ = 0;
};

bool WatchesProbe(const Watch& watch);
bool WatchesSwitch(const Watch& watch);

/// Motor steps at power-up: the tool in the middle, near the top.
Vec3<double> PowerUpSteps(const Built& built);

}  // namespace caltwin
