#pragma once

#include <vector>

#include "sim/base/rng.h"
#include "sim/effects/effect.h"
#include "sim/effects/predict.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/machine/machine_kind.h"
#include "sim/machine/surface.h"

namespace caltwin {

enum class Stylus { kBall, kDisc };

/// The machine as built, in closed form: drawing plus effects plus what lies on the
/// table. Fast fidelity is made of it; physics uses its drive map, its tool's place,
/// its probe switch and its table's shape: whatever acts while the machine runs.
struct Built {
  Machine machine{};
  std::vector<Injected> effects{};
  std::vector<Artefact> artefacts{};  ///< As drawn.
  Stylus stylus = Stylus::kBall;
  double probe_sigma_mm = 0;  ///< Of the instrument `probe`, beside trigger_scatter.
  /// The circumstances of now: time, homing, temperatures, spindle, load, sense. Where
  /// and in which direction is filled in by whoever asks.
  At now{.kind = RowKind::kTouch, .on_table = true};
  /// Where each axis last turned round, commanded: tells the travel since, where `now`
  /// does not.
  Vec3<double> turned_at_mm = Vec3<double>::Constant(kUnknown);

  /// @name Derived once by Prepare()
  Vec3<double> steps_per_mm = Vec3<double>::Zero();  ///< True, by drive.
  /// Width of each drive's play, as far as it is the same everywhere.
  Vec3<double> lost_motion_mm = Vec3<double>::Zero();
  /// Middle of each drive's play, carriage minus motor: not 0 where a load hangs.
  Vec3<double> lag_center_mm = Vec3<double>::Zero();
  Errors<double> probe{};                 ///< Pre-travels, radius, latency.
  std::vector<Injected> drive_effects{};  ///< Bend the way from steps to nut, or widen
                                          ///< the play somewhere.
  std::vector<Injected> frame_effects{};  ///< Not the drive's, and move the tool.
  std::vector<Injected> tool_effects{};   ///< Move the tool or the switch's threshold.
  std::vector<Injected> table_effects{};  ///< Raise what is touched.
  /// Of these, those that act while the machine runs: all but a tilt of the model.
  std::vector<Injected> raising_effects{};
  /// What displaces a surface though no model of it is turned or resized: all but a
  /// tilt of the model.
  std::vector<Injected> surface_effects{};
  std::vector<Artefact> standing{};      ///< Artefacts as built and turned.
  std::vector<Solid> solids{};           ///< Table and artefacts, untilted.
  std::vector<Solid> solids_for_disc{};  ///< The same, grown sideways by the disc.

  void Prepare();

  /// Null: each axis has a drive of its own, and by drive is by axis.
  const DriveMap* drives() const { return machine.kind->drive_map(); }
  /// Where the drives stand when homed.
  Vec3<double> DrivesHome_mm() const;
  /// `now` where the axes were told to stand, with the travel since they turned round.
  At AtAxes(const Vec3<double>& q_mm) const;
  /// Commanded position for motor steps, by the drawing's steps per mm.
  Vec3<double> Drawn_mm(const Vec3<double>& steps) const;
  /// What the drive adds to where the nuts should stand at a commanded position.
  Vec3<double> DriveBend_mm(const Vec3<double>& q_mm) const;
  /// Width of each drive's play there; its part that is not the same everywhere.
  Vec3<double> LostMotion_mm(const Vec3<double>& q_mm) const;
  Vec3<double> LocalLostMotion_mm(const Vec3<double>& q_mm) const;
  /// How far the tool stands off its place on the carriage.
  Vec3<double> ToolOffset_mm(const Vec3<double>& q_mm) const;

  /// Where the motors alone would put what each drive pulls: home + steps / true steps
  /// per mm, and what the drive adds.
  Vec3<double> Motors_mm(const Vec3<double>& steps) const;
  /// Its inverse, to 1e-9 mm.
  Vec3<double> StepsAt(const Vec3<double>& motors_mm) const;
  /// Carriage minus motor of each drive once its motor has come straight, in one sense,
  /// from where it was `from_lag_mm`.
  Vec3<double> LagAt_mm(const Vec3<double>& from_lag_mm,
                        const Vec3<double>& from_steps,
                        const Vec3<double>& to_steps) const;
  /// Position of the ball's centre, `lag_mm` being carriage minus motor of each drive
  /// (within half the play), stylus undeflected.
  Vec3<double> Tip_mm(const Vec3<double>& steps, const Vec3<double>& lag_mm) const;

  /// Distance from the tip's surface to the nearest solid, tilted table and all;
  /// negative: the stylus is deflected by as much.
  SurfaceDistance Clearance(const Vec3<double>& tip_mm) const;
  /// Deflection at the trigger towards a surface of that normal, without scatter.
  double Pretravel_mm(const Vec3<double>& normal) const;
  double scatter_mm() const;

  /// What the table's effects add to a surface at that point, along its normal.
  double Table_mm(const Vec3<double>& p_mm, const Vec3<double>& normal) const;
  /// How far the table itself is raised there while the machine runs.
  double Raised_mm(const Vec3<double>& p_mm) const;
  /// The same where a flat disc at `p_mm` first touches the solid's flat.
  double TableUnderDisc_mm(const Vec3<double>& p_mm,
                           const SurfaceDistance& nearest) const;
};

/// The play operator: how far the carriage lags (carriage minus motor) after the motor
/// has moved by `travel_mm` in one sense, with a play of `width_mm`.
double LagAfter_mm(double lag_mm, double travel_mm, double width_mm);

}  // namespace caltwin
