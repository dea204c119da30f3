#pragma once

#include <memory>

#include "sim/effects/effect.h"
#include "sim/measure/row.h"
#include "sim/physics/world.h"
#include "sim/twin/built.h"

namespace caltwin {

/// The machine in MuJoCo, put through single readings: for each it is stood a little
/// way before it, with its gaps taken up as the row's senses say, and goes the rest as
/// a machine would. What it reads comes from MuJoCo: the tip's place by kinematics, a
/// touch by contact and the deflection of the stylus.
///
/// A person may have changed the model (bent a rail, opened a gap, turned an axis, put
/// a shape on the table): nothing here knows what it ought to be. Where a gap is found
/// not to be taken up, the machine comes from further away; where the row says that an
/// axis has turned round less than its gap ago, its nut comes no further than that.
class MeasuringMachine {
 public:
  MeasuringMachine(const Machine& machine, const std::vector<Injected>& effects);

  /// Moves there, coming as `at.dir` says, and tells (actual - commanded) . n as the
  /// tip passes the commanded pose at 2 mm/s: slow enough that nothing but the rail's
  /// friction pulls at the drive.
  double Position_mm(const At& at);

  /// Touches what stands at `nominal_mm`, facing `at.n`: (reported - nominal) . n, to
  /// fractions of a step. Throws InputError at `row.place` where it never triggers.
  double Touch_mm(const Row& row, const At& at);

 private:
  /// One straight way of the axes, commanded; constant feed. `sense` below is by drive.
  struct Way {
    Vec3<double> from_mm = Vec3<double>::Zero();
    Vec3<double> feed_mm_s = Vec3<double>::Zero();
    Vec3<double> At(double t_s) const { return from_mm + t_s * feed_mm_s; }
  };
  void Prepare(const At& at, const Vec3<double>& sense);
  Way WayOf(const At& at, const Vec3<double>& sense, double way_mm) const;
  Vec3<double> Nuts_mm(const Vec3<double>& q_mm) const;
  Vec3<double> Lag_mm() const;
  void Stand(const Way& way);
  void Step(const Way& way, int step);
  bool GoesSteadily(const Way& way, int steps);
  void Aim(const Row& row, const At& at);
  Way Approach(const At& at, double feed_mm_s);
  double TriggerTime_s(const Row& row, const Way& way, double threshold_mm);
  double ReleaseTime_s(const Row& row, const Way& way, double threshold_mm);

  Built built_;
  std::unique_ptr<World> world_;
  Vec3<double> drawn_gap_mm_ = Vec3<double>::Zero();  ///< As the model has them.
  Vec3<double> gap_mm_ = Vec3<double>::Zero();        ///< As they are now.
  Vec3<double> lag_mm_ = Vec3<double>::Zero();        ///< Carriage minus nut, expected.
  Vec3<double> told_dir_ = Vec3<double>::Zero();      ///< Of drives, as the row has it.
  /// How far the nut of an axis that stands within its gap has come since it left the
  /// other side; infinite where it pushes.
  Vec3<double> crossed_mm_ = Vec3<double>::Zero();
};

}  // namespace caltwin
