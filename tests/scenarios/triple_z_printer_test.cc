// The printer that procedures speak to, on the twin's firmware: where it takes the
// screws to stand is where they are.

#include <gtest/gtest.h>

#include "calibration/kinds/triple_z/printer.h"
#include "calibration/kinds/triple_z/procedures.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "tests/firmware/screw_bed.h"

namespace caltwin {
namespace {

const Pivots<double> kDrawn_mm = TripleZDrawing{}.pivots_mm();

// A bed that stands where it was raised, a little tilted.
double Raised_mm(const Vec3<double>& raised_mm, double x_mm, double y_mm) {
  return ScrewWeights<double>(kDrawn_mm, x_mm, y_mm)
      .dot(raised_mm + Vec3<double>(0.4, -0.3, 0.2));
}

// Whatever moved them before: the same heights are the same bed.
TEST(TripleZPrinter, ScrewsAreAtTheHeightsAskedForWhateverMovedThemBefore) {
  ScrewBed bed(Raised_mm);
  const Machine machine = ScrewBedMachine();
  Firmware firmware(
      machine, machine.settings, {.leadscrews = Leadscrews{.at_mm = kDrawn_mm}}, &bed);
  EmulatedLink wire(&firmware);
  TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});
  const Vec3<double> level_mm = Vec3<double>::Constant(240);
  const auto off_mm = [&] {
    EXPECT_TRUE(printer.MoveTripleZ(117, 117, level_mm));
    return (firmware.raised_mm().array() - firmware.raised_mm()[0]).abs().maxCoeff();
  };
  constexpr double kStep_mm = 1.0 / 800;

  EXPECT_LT(off_mm(), kStep_mm);
  ASSERT_TRUE(printer.Raise({0.5, -0.4, 0.1}));
  ASSERT_TRUE(printer.Probe({20, 20}));
  EXPECT_LT(off_mm(), kStep_mm);
  ASSERT_TRUE(printer.Level({{20, 20}, {215, 20}, {20, 215}}));
  EXPECT_GT((firmware.raised_mm().array() - firmware.raised_mm()[0]).abs().maxCoeff(),
            0.1);
  EXPECT_LT(off_mm(), 2 * kStep_mm);  // Adjustments are printed in micrometres.
  ASSERT_TRUE(printer.Raise({0.5, -0.4, 0.1}));
  ASSERT_FALSE(firmware.Execute(" g28 ").error);
  printer.Heard(" g28 ");
  EXPECT_LT(off_mm(), kStep_mm);
  ASSERT_FALSE(firmware.Execute("G92 Z17").error);
  printer.Heard("G92 Z17");
  EXPECT_LT(off_mm(), kStep_mm);
}

// Raised by 3 mm the far corner stands over the height from which the probe dives.
TEST(TripleZPrinter, AScrewIsMovedByLessWhereTheBedComesTooNear) {
  ScrewBed bed([](const Vec3<double>& raised_mm, double x_mm, double y_mm) {
    return ScrewWeights<double>(kDrawn_mm, x_mm, y_mm)
        .dot(raised_mm + Vec3<double>(-2, 0.5, 0.5));
  });
  const Machine machine = ScrewBedMachine();
  Firmware firmware(
      machine, machine.settings, {.leadscrews = Leadscrews{.at_mm = kDrawn_mm}}, &bed);
  EmulatedLink wire(&firmware);
  TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});

  const TripleZResult found = RunPivotsAndWiring(&printer, {.test_mm = 3});

  EXPECT_EQ(found.result.ending, Ending::kDone) << found.result.fault;
  ASSERT_TRUE(found.response);
  for (std::size_t i = 0; i < kDrawn_mm.size(); ++i) {
    EXPECT_LT((found.response->at_mm[i] - kDrawn_mm[i]).norm(), 0.2) << i;
  }
  EXPECT_LT(firmware.raised_mm().norm(), 1e-9);  // Put back.
}

}  // namespace
}  // namespace caltwin
