#include "calibration/diagnosis/correction.h"

#include <cmath>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// One row of a gauge with the probe 30 mm beside the nozzle: enough to stand on.
Observed SomeRows() {
  Row row;
  row.n = {1, 0, 0};
  row.cmd_mm = {10, 0, 0};
  row.probe_off_mm = {0, 30, 0};
  return {{.rows = {row}}, {}, Machine{}, {}};
}

Finding Named(const char* cause, const char* axis, std::vector<double> values) {
  return {.cause = cause,
          .axis = axis,
          .effect = Injected{.effect = *FindEffect(cause),
                             .axis = axis,
                             .values = std::move(values)},
          .sds = {0}};
}

std::string First(ControllerKind controller, const Diagnosis& diagnosis) {
  return CorrectionFor(controller, diagnosis, SomeRows(), "c.txt").at(0).text;
}

// The number after `before` in the text.
double After(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before << " in\n" << text;
  return at == std::string::npos ? NAN : std::stod(text.substr(at + before.size()));
}

Vec3<double> Motion_mm(const std::vector<Injected>& built, const At& at) {
  return ErrorsAt<double>(Machine{}, at, built).motion_mm;
}

TEST(Correction, OfScaleAndBacklashLeavesNoMotionError) {
  // Built with 792 steps/mm and a gap, run with 800 and none.
  const std::vector<Injected> built{
      {.effect = EffectIndex<StepsPerMm>(), .axis = "x", .values = {792}},
      {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {0.05}}};
  const Diagnosis diagnosis{
      .baseline = {{"scale.x", "ppm", (800.0 / 792 - 1) * 1e6, 10},
                   {"backlash.x", "mm", 0.05, 0.001}}};
  const double kRounding_mm = 1e-4;

  for (const ControllerKind controller :
       {ControllerKind::kRrf, ControllerKind::kMarlin}) {
    const std::string text = First(controller, diagnosis);

    At at{.q_mm = {200, 0, 0}, .dir = {1, 0, 0}};
    at.steps_per_mm = {After(text, "M92 X"), 0, 0};
    at.compensation_mm = {
        After(text, controller == ControllerKind::kMarlin ? "M425 F1 X" : "M425 X"),
        0,
        0};
    EXPECT_NEAR(Motion_mm(built, at).x(), 0, kRounding_mm);
  }
  const std::string klipper = First(ControllerKind::kKlipper, diagnosis);
  EXPECT_NEAR(After(klipper, "rotation_distance: "), 3200 / 792.0, 1e-5);
  EXPECT_THAT(klipper, HasSubstr("Klipper has no backlash compensation"));
  EXPECT_NEAR(
      After(First(ControllerKind::kLinuxCnc, diagnosis), "SCALE = "), 792, 1e-3);
}

// A sense written the wrong way round makes a gap that leads; none is compensated.
TEST(Correction, AGapThatLeadsIsAComment) {
  const Diagnosis diagnosis{.baseline = {{"backlash.x", "mm", -0.0135, 0.0012}}};

  for (const ControllerKind controller :
       {ControllerKind::kRrf, ControllerKind::kMarlin, ControllerKind::kLinuxCnc}) {
    const std::string text = First(controller, diagnosis);
    EXPECT_THAT(text, Not(HasSubstr("M425")));
    EXPECT_THAT(text, Not(HasSubstr("BACKLASH")));
    EXPECT_THAT(text, HasSubstr("a gap that leads is none"));
  }
}

// What rows left out speak against is no correction; what holds between the ends is.
TEST(Correction, ATableThatMakesUnseenRowsWorseIsNotWritten) {
  Finding map{.cause = "pitch_map", .axis = "x", .covariates = {"x"}};
  map.map = FreeMap{.channel = "x",
                    .covariates = {"x"},
                    .knots = {{0, 150, 300}},
                    .values_um = {-10, 5, 10}};
  Diagnosis diagnosis{.findings = {map}};
  const auto files = [&] {
    return CorrectionFor(ControllerKind::kLinuxCnc, diagnosis, SomeRows(), "c.txt");
  };
  EXPECT_THAT(files(), SizeIs(2));

  diagnosis.gain.ends = {.before_mm = 0.01, .after_mm = 0.03, .groups = 2};
  EXPECT_THAT(files(), SizeIs(2));
  EXPECT_THAT(files()[0].text, HasSubstr("between the first and the last position"));

  diagnosis.gain.positions = {.before_mm = 0.01, .after_mm = 0.02, .groups = 5};
  EXPECT_THAT(files(), SizeIs(1));
  EXPECT_THAT(files()[0].text, HasSubstr("pitch_map.x: Do not correct by it"));
}

TEST(Correction, OfSquarenessUndoesTheLean) {
  const Diagnosis diagnosis{.findings = {Named("squareness", "C0Y", {2}),
                                         Named("squareness", "B0Z", {-3}),
                                         Named("squareness", "A0Z", {1.5})}};
  std::vector<Injected> built;
  for (const Finding& finding : diagnosis.findings) built.push_back(*finding.effect);
  const std::string rrf = First(ControllerKind::kRrf, diagnosis);
  const std::string marlin = First(ControllerKind::kMarlin, diagnosis);
  const std::string klipper = First(ControllerKind::kKlipper, diagnosis);
  const Vec3<double> here(40, 200, 90), there(240, 30, 10);
  const auto left = [&](const auto& motors) {
    // From place to place, so that where the axes have their zero does not matter.
    const auto reached = [&](const Vec3<double>& wanted) {
      const Vec3<double> q = motors(wanted);
      return Vec3<double>(q + Motion_mm(built, {.q_mm = q}) - wanted);
    };
    return (reached(here) - reached(there)).norm();
  };
  const double none_mm = left([](const Vec3<double>& q) { return q; });
  ASSERT_GT(none_mm, 0.3);
  // Squares of angles over the way: 3 mrad squared, 250 mm.
  const double neglected_mm = 4 * 9e-6 * 250;

  EXPECT_LT(left([&](Vec3<double> q) {
              const double s = After(rrf, "M556 S");
              q.x() += q.y() * After(rrf, " X") / s + q.z() * After(rrf, " Z") / s;
              q.y() += q.z() * After(rrf, " Y") / s;
              return q;
            }),
            neglected_mm);
  EXPECT_LT(left([&](Vec3<double> q) {
              q.x() -= q.y() * After(marlin, "M852 I") + q.z() * After(marlin, " J");
              q.y() -= q.z() * After(marlin, " K");
              return q;
            }),
            neglected_mm);
  EXPECT_LT(left([&](Vec3<double> q) {
              q.x() -= q.y() * After(klipper, "xy_skew: ") +
                       q.z() * After(klipper, "xz_skew: ");
              q.y() -= q.z() * After(klipper, "yz_skew: ");
              return q;
            }),
            neglected_mm);
}

TEST(Correction, ByAScrewTableLeavesNoBendAndNoGap) {
  Diagnosis diagnosis{.findings = {Named("pitch_progressive", "x", {80})},
                      .baseline = {{"backlash.x", "mm", 0.03, 0.001}}};
  const std::vector<Injected> built{
      *diagnosis.findings[0].effect,
      {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {0.03}}};

  const auto files =
      CorrectionFor(ControllerKind::kLinuxCnc, diagnosis, SomeRows(), "c");

  ASSERT_THAT(files, SizeIs(2));
  EXPECT_THAT(files[0].text, HasSubstr("COMP_FILE = c.x.comp"));
  std::istringstream table(files[1].text);
  double nominal_mm = 0, forward_mm = 0, backward_mm = 0;
  int points = 0;
  while (table >> nominal_mm >> forward_mm >> backward_mm) {
    ++points;
    for (const double sense : {1.0, -1.0}) {
      const double actual_mm = sense > 0 ? forward_mm : backward_mm;
      const At at{.kind = RowKind::kPosition,
                  .q_mm = {nominal_mm + (nominal_mm - actual_mm), 0, 0},
                  .dir = {sense, 0, 0}};
      // The bend's slope, 4 bow / travel, times the correction: 0.1 um.
      EXPECT_NEAR(at.q_mm.x() + Motion_mm(built, at).x(), nominal_mm, 2e-4);
    }
  }
  EXPECT_GE(points, 21);
}

TEST(Correction, OfATwistedBeamRaisesWhatTheProbeReadsLow) {
  const Diagnosis diagnosis{.findings = {Named("axis_twist", "", {1})}};

  const std::string text = First(ControllerKind::kKlipper, diagnosis);

  // A touch from above: value + compensation is what the nozzle would have found.
  At at{.q_mm = {0, 150, 0}, .n = {0, 0, 1}, .probe_off_mm = {0, 30, 0}};
  const std::vector<Injected> built{*diagnosis.findings[0].effect};
  const double wrong_mm =
      Predict_mm<double>(Machine{}, at, built) - Predict_mm<double>(Machine{}, at, {});
  ASSERT_GT(std::abs(wrong_mm), 0.01);
  EXPECT_NEAR(wrong_mm + After(text, "z_compensations: "), 0, 1e-5);
}

TEST(Correction, SaysWhatItCannotCarryAndWhatToDo) {
  const Diagnosis diagnosis{.findings = {Named("gantry_sag", "", {30})}};

  EXPECT_THAT(First(ControllerKind::kMarlin, diagnosis),
              HasSubstr("; gantry_sag: no line for Marlin is written for this. "));
}

}  // namespace
}  // namespace caltwin
