#pragma once

#include <vector>

#include "sim/base/rng.h"
#include "sim/effects/effect.h"
#include "sim/effects/predict.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/machine/surface.h"

namespace caltwin {

enum class Stylus { kBall, kDisc };

/// The machine as built, in closed form: drawing plus effects plus what lies on the
/// table. Fast fidelity is made of it; physics uses its drive map and its probe switch.
struct Built {
  Machine machine{};
  std::vector<Injected> effects{};
  std::vector<Artefact> artefacts{};
  Stylus stylus = Stylus::kBall;
  double probe_sigma_mm = 0;  ///< Of the instrument `probe`, beside trigger_scatter.

  /// @name Derived once by Prepare()
  Vec3<double> steps_per_mm = Vec3<double>::Zero();    ///< True.
  Vec3<double> lost_motion_mm = Vec3<double>::Zero();  ///< Width of each axis' play.
  /// Middle of each carriage's play, carriage minus motor: not 0 where a load hangs.
  Vec3<double> lag_center_mm = Vec3<double>::Zero();
  Errors<double> probe{};                 ///< Pre-travels, radius, latency.
  std::vector<Injected> table_effects{};  ///< Of the artefact stage only.
  std::vector<Solid> solids{};            ///< Table and artefacts, untilted.
  std::vector<Solid> solids_for_disc{};   ///< The same, grown sideways by the disc.

  void Prepare();

  /// Where the motors alone would put each carriage: home + steps / true steps per mm.
  Vec3<double> Motors_mm(const Vec3<double>& steps) const;
  Vec3<double> StepsAt(const Vec3<double>& motors_mm) const;
  /// Position of the ball's centre, `lag_mm` being carriage minus motor on each axis
  /// (within half the play), stylus undeflected.
  Vec3<double> Tip_mm(const Vec3<double>& steps, const Vec3<double>& lag_mm) const;

  /// Distance from the tip's surface to the nearest solid, tilted table and all;
  /// negative: the stylus is deflected by as much.
  SurfaceDistance Clearance(const Vec3<double>& tip_mm) const;
  /// Deflection at the trigger towards a surface of that normal, without scatter.
  double Pretravel_mm(const Vec3<double>& normal) const {
    return caltwin::Pretravel_mm(probe, normal);
  }
  double scatter_mm() const;

  /// What the table's effects add to a surface at that point, along its normal.
  double Table_mm(const Vec3<double>& p_mm, const Vec3<double>& normal) const;
  /// The same where a flat disc at `p_mm` first touches the solid's flat.
  double TableUnderDisc_mm(const Vec3<double>& p_mm,
                           const SurfaceDistance& nearest) const;
};

/// The play operator: how far the carriage lags (carriage minus motor) after the motor
/// has moved by `travel_mm` in one sense, with a play of `width_mm`.
double LagAfter_mm(double lag_mm, double travel_mm, double width_mm);

}  // namespace caltwin
