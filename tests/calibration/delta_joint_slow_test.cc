// Where the joint estimate of a delta may start from.
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/kinds/delta/joint.h"
#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {
namespace {

// Endstops and radius within 5 mm, angles within 2 deg of the drawing: 10 000 machines.
TEST(DeltaJoint, ConvergesFromFarOff) {
  constexpr int kStarts = 10'000;
  const DeltaModel<double> believed = SymmetricDelta(300, 130, 250);
  std::vector<Vec3<double>> points = {{0, 0, 0}};
  for (int ring = 1; ring <= 2; ++ring) {
    for (int i = 0; i < 8; ++i) {
      const double angle = 2 * M_PI * (i + 0.5 * ring) / 8;
      points.emplace_back(45 * ring * std::cos(angle), 45 * ring * std::sin(angle), 0);
    }
  }
  Rng rng(1, 0, "delta.starts");
  const auto within = [&](double most) {
    return most * (2 * rng.Uniform() - 1);
  };
  int converged = 0;
  for (int start = 0; start < kStarts; ++start) {
    DeltaBuild<double> build{.model = believed};
    for (double& endstop : build.model.endstop_mm) endstop += within(5);
    const double more_mm = within(5);
    for (double& radius : build.model.radius_mm) radius += more_mm;
    build.model.angle_rad[0] += within(2) * kDegree;
    build.model.angle_rad[1] += within(2) * kDegree;
    SimulatedDelta machine(build, {}, 0, 1);
    DeltaReadings readings;
    for (const Vec3<double>& at : points) {
      const auto motors = machine.Touch(believed, at[0], at[1]);
      if (motors) readings.touches.push_back({*motors, 0, 0.01});
    }
    const DeltaJointFit fit =
        FitDeltaJointly({.model = believed}, readings, {.knobs = {0, 1, 2, 3, 4, 5}});
    const double off_mm = DeltaAccuracyOf(build, {}, fit.build.model, 90).z_most_mm;
    if (fit.converged && off_mm < 0.001) ++converged;
  }
  EXPECT_EQ(converged, kStarts);
}

}  // namespace
}  // namespace caltwin
