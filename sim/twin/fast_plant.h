#pragma once

#include "sim/twin/twin_plant.h"

namespace caltwin {

/// The machine in closed form: no time stepping. Triggers are found by tracing the
/// tip's path towards the surfaces of sim/machine/surface.h to 1e-9 mm.
///
/// Quasi-static: a carriage stands where the play operator puts it, the stylus is bent
/// by as much as the ball would otherwise be inside. Neglects coasting and ringing.
class FastPlant final : public TwinPlant {
 public:
  FastPlant(Built built, std::uint64_t seed, std::uint64_t sample);

  Outcome Run(const Segment& segment, const Watch& watch) override;
  void Settle(const Motors& steps) override;
  void Dwell(double s) override { Pass(s); }
  bool ProbeTriggered() override;
  bool SwitchClosed(Axis axis) override;
  void Change(const std::vector<Artefact>& artefacts, Stylus stylus) override;
  Vec3<double> Tip_mm() override;

 private:
  /// How far the machine can still go, at motor steps on the way: before what is
  /// watched for happens, and before the stylus is bent more than `allowed_mm`.
  struct Ahead {
    double watched_mm = 0;
    double collision_mm = 0;
  };
  Ahead Look(const Watch& watch,
             const Segment& segment,
             const Vec3<double>& steps,
             double allowed_mm) const;
  void GoTo(const Vec3<double>& steps);

  Vec3<double> lag_mm_;  ///< Carriage minus motor, by drive.
  bool triggered_ = false;
};

}  // namespace caltwin
