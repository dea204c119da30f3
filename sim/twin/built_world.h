#pragma once

#include <optional>

#include "sim/physics/world.h"
#include "sim/twin/built.h"

namespace caltwin {

/// The drawing's hanging weight less its counterbalance: along -z on the carriage of Z.
double HangingLoad_n(const Machine& machine);

/// A machine as built in MuJoCo, with what lies on its table. What acts while it runs
/// follows the closed forms: tool, table and widths of the plays are brought to where
/// these have them. Contact, stylus and carriages are MuJoCo's.
class BuiltWorld : public World {
 public:
  static constexpr double kTimestep_s = 2e-4;
  /// Less than this no stylus is bent.
  static constexpr double kAtRest_mm = 1e-6;

  /// @param drawn  the model with the drawing applied, before effects and artefacts
  BuiltWorld(const Mjcf& drawn, const Built& built);

  /// The plays' widths as the model has them.
  const Vec3<double>& drawn_gap_mm() const { return drawn_gap_mm_; }
  /// Brings tool, table and plays to where they are with the motors there; the tool
  /// beside that by `moved_mm`.
  void Feel(const Built& built,
            const Vec3<double>& steps,
            const Vec3<double>& moved_mm = Vec3<double>::Zero());
  /// Puts it there at rest, its stylus not bent, forgetting what was.
  /// @param lag_mm  carriage minus motor of each drive
  void StandAt(const Built& built,
               const Vec3<double>& steps,
               const Vec3<double>& lag_mm,
               const Vec3<double>& moved_mm = Vec3<double>::Zero());

  /// Deflection of the stylus beyond that at which the switch opens, along the
  /// direction of deflection, scatter apart; nullopt: it is not bent.
  std::optional<double> BeyondTrigger_mm(const Built& built) const;
  /// The same once the stylus has come to rest, the motors standing at `steps`.
  std::optional<double> RestsBeyondTrigger_mm(const Built& built,
                                              const Vec3<double>& steps);

 private:
  Vec3<double> drawn_gap_mm_ = Vec3<double>::Zero(), gap_mm_ = Vec3<double>::Zero();
  bool is_tool_moved_ = false;  ///< It was ever moved: no more where the model has it.
};

}  // namespace caltwin
