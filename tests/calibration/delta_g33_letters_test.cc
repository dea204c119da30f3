// G33's letters, as Marlin takes them.

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/g33.h"
#include "sim/base/input_error.h"
#include "sim/machine/kinds/delta/model.h"
#include "tests/calibration/delta_engine_rows.h"

namespace caltwin {
namespace {

using delta_rows::Believed;
using testing::StrEq;

G33Options Read(const char* line, const G33Options& options = {}) {
  return ReadG33(ParseGcode(line).commands[0], options);
}

std::string RefusalOf(const char* line) {
  try {
    Read(line);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(G33Letters, AreTakenAsMarlinTakesThem) {
  const G33Options bare = Read("G33");
  EXPECT_EQ(bare.points, 4);
  EXPECT_TRUE(bare.tower_angles);
  EXPECT_EQ(bare.verbosity, G33Verbosity::kEnds);

  const G33Options all = Read("G33 P7 C0.01 F3 V0 T E O1 R12.5");
  EXPECT_EQ(all.points, 7);
  EXPECT_EQ(all.precision_mm, 0.01);
  EXPECT_EQ(all.force_iterations, 3);
  EXPECT_EQ(all.verbosity, G33Verbosity::kDryRun);
  EXPECT_FALSE(all.tower_angles);
  EXPECT_TRUE(all.engages_probe);
  EXPECT_TRUE(all.probes_at_offset);
  EXPECT_EQ(all.reduce_mm, 12.5);
  EXPECT_FALSE(Read("G33 E0 O0").engages_probe);
}

TEST(G33Letters, ImplausibleOnesAreRefusedInMarlinsWords) {
  EXPECT_THAT(RefusalOf("G33 P11"), StrEq("?(P)oints implausible (0-10)."));
  EXPECT_THAT(RefusalOf("G33 V4"), StrEq("?(V)erbose level implausible (0-3)."));
  EXPECT_THAT(RefusalOf("G33 F31"), StrEq("?(F)orce iteration implausible (0-30)."));
  EXPECT_THAT(RefusalOf("G33 F1000000000000"),
              StrEq("?(F)orce iteration implausible (0-30)."));
  EXPECT_THAT(RefusalOf("G33 C-1"),
              StrEq("?(C)alibration precision implausible (>=0)."));
  EXPECT_THAT(RefusalOf("G33 R100"), StrEq("?(R)educed to no radius at all."));
}

// A tip that stands aside reads the bed beside the nozzle: G33 then tilts the machine
// by the bed's slope times that; where it is told (O), the nozzle goes beside instead,
// and the same grid of the bed is touched.
TEST(G33Letters, TheTipGoesToThePointWithOAndTheNozzleWithout) {
  G33Options options{.points = 2, .verbosity = G33Verbosity::kDryRun};
  options.probe_offset_mm = {20, 0, 0};
  for (const bool at_offset : {false, true}) {
    options.probes_at_offset = at_offset;
    std::vector<Eigen::Vector2d> nozzles_mm;
    const DeltaProbe probe = [&](const DeltaModel<double>& settings,
                                 double x_mm,
                                 double y_mm) -> std::optional<Vec3<double>> {
      nozzles_mm.emplace_back(x_mm, y_mm);
      return DeltaMotors_mm<double>(settings, {x_mm, y_mm, 0});
    };
    CalibrateG33(probe, Believed(), options);
    ASSERT_EQ(nozzles_mm.size(), 4U);
    // The reach allows a smaller circle where the nozzle stands in its middle.
    Eigen::Vector2d middle_mm = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& at : nozzles_mm) middle_mm += at / 4;
    EXPECT_NEAR(middle_mm[0], at_offset ? -20 : 0, 1e-9);
    EXPECT_NEAR((nozzles_mm[0] - nozzles_mm[1]).norm(), 80, 1e-9);
  }
}

}  // namespace
}  // namespace caltwin
