#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sim/kinds/cartesian/stepped.h"
#include "sim/machine/kinds/corexy/drawing.h"

namespace caltwin {

/// A number for each of them, in the order of CornersDrawing.
using Corners = Eigen::Matrix<double, CornersDrawing::kNum, 1>;

/// A CoreXY whose gantry hangs on four motors of Z, its motors stepped one by one: X,
/// Y, Z, Z1, Z2, Z3. The first of Z has a switch; the others follow from where they
/// stand. `backlash.z` is each corner's own.
class SteppedCorners final : public SteppedTip {
 public:
  /// The machine has a CornersDrawing.
  SteppedCorners(const Built& built, bool is_physics, std::uint64_t seed);

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& steps) override;
  void Arm(const PinSensor& sensor) override { gantry_.Arm(sensor); }
  Vec3<double> Tip_mm() const override { return gantry_.Tip_mm(); }

 private:
  /// Nut minus motor of each, having come there from where it was followed to.
  Corners LagAt_mm(const Motors& steps) const;
  /// The same with one motor of Z, without play, that has the head as high where it is;
  /// or as high as the first corner, where the switch is.
  Motors AsOne(const Motors& steps, bool is_at_first) const;

  Built built_;
  SteppedGantry gantry_;
  Corners steps_ = Corners::Zero(), lag_mm_ = Corners::Zero();
};

/// How it is wired: as WiringOfGantry, and Z1 to Z3. When it is switched on its corners
/// stand up to 2 mm apart.
Wiring WiringOfCorners(const Machine& machine);
/// Of such a machine or of a gantry.
Wiring WiringOf(const Machine& machine);

/// A board and the machine on it, which it owns.
struct BoardWithTip {
  std::unique_ptr<PlantBoard> board{};
  SteppedTip* plant = nullptr;
};

/// A board with such a machine on it, or with a gantry that has one motor of Z, wired
/// as WiringOf says.
BoardWithTip BoardOfGantry(const Built& built, bool is_physics, std::uint64_t seed);

/// Three motors more of Z, and [quad_gantry_level].
std::string CornersCfg(const Machine& machine);

/// How high the ball is over the table with the head at (x, y) and the corners as these
/// motors have them, as the plant counts, lifted by 50 mm; play left out.
double OverTableAt_mm(const Built& built,
                      const Motors& steps,
                      const Eigen::Vector2d& at_mm);

/// How uneven the ball stands over the table with the motors there: rms about the mean
/// of 49 places, nine tenths of the travel wide, play left out [mm].
double FlatnessOfCorners_mm(const Built& built, const Motors& steps);

}  // namespace caltwin
