// The truth code against rows computed by hand, so that a wrong sign of the diagnosis
// is not excused by the same wrong sign here.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/blind/case.h"
#include "tests/blind/visible.h"

namespace blind {
namespace {

constexpr double kNeglected_mm = 1e-7;  // Bisection, and slopes times micrometres.
constexpr double kPretravel_mm = 0.02;

Drawing PlainDrawing() {
  Drawing drawing;
  drawing.axes[2].max_mm = 120;
  return drawing;
}

Truth PlainTruth() {
  Truth truth;
  truth.pretravel_mm = {kPretravel_mm, kPretravel_mm, kPretravel_mm};
  return truth;
}

double ValueOf(const Stop& stop, const Truth& plain, double t_s = 10) {
  Plan plan;
  plan.stops = {stop};
  plan.placements[stop.setup] = {.center_mm = {150, 150, 0}};
  Truth truth = plain;
  truth.standing[stop.setup];
  return Machine(PlainDrawing(), truth).Perform(plan, {t_s})[0].value_mm;
}

Stop Gauge(const Vector3& at, const Vector3& n, double sense = 1) {
  Stop stop;
  stop.at_mm = at;
  stop.n = n;
  stop.via = {at - (10 * sense) * n};
  return stop;
}

Stop Face(const Vector3& at, const Vector3& n) {
  return Touch("c", "s", "block.face", at, n);
}

/// The defect with size 1 as the catalogue makes it, on a quiet day of two hours.
Defect Made(const std::string& cause, const std::string& axis) {
  static const Drawing drawing = PlainDrawing();
  static const Weather weather(
      {.duration_s = 7200, .from_cold = true, .heating_until_s = 7200},
      Random(3, "weather"));
  static const Plan plan = [] {
    Plan made;
    made.stops.assign(10, Face({100, 100, 10}, Along(0)));
    for (Stop& stop : made.stops) stop.campaign = "alternating";
    return made;
  }();
  static const std::vector<double> times_s = {
      100, 200, 300, 400, 500, 600, 700, 800, 900, 1000};
  Random random(5, cause + axis);
  return FindCause(cause)->make(axis, {drawing, weather, plan, times_s, &random});
}

double Parameter(const Defect& defect, const std::string& name) {
  for (const auto& parameter : defect.parameters) {
    if (parameter.name == name) return parameter.value;
  }
  return std::nan("");
}

/// What the defect adds to a row [um], per size.
double Adds_um(const Defect& defect, const Stop& stop, double t_s = 10) {
  Truth with = PlainTruth();
  with.defects = {defect};
  return (ValueOf(stop, with, t_s) - ValueOf(stop, PlainTruth(), t_s)) / kMmPerUm;
}

constexpr double kNear_um = 1e-3;

TEST(BlindMachine, MovingOnePercentTooFarReadsPlusOnAGaugeAndMinusOnATouch) {
  Truth truth = PlainTruth();
  truth.scale[0] = 0.01;

  EXPECT_NEAR(ValueOf(Gauge({100, 150, 60}, Along(0)), truth), 1.0, kNeglected_mm);
  // Face at 100 looking to +x: 1.01 c = 100 + 1 - 0.02; value = c - 100 - 1.
  const double centre_mm = (101 - kPretravel_mm) / 1.01;
  EXPECT_NEAR(
      ValueOf(Face({100, 150, 10}, Along(0)), truth), centre_mm - 101, kNeglected_mm);
}

TEST(BlindMachine, PretravelReadsMinusItselfOnEveryFace) {
  for (const auto& n : {Along(0), Along(0, -1), Along(1), Along(1, -1), Along(2)}) {
    EXPECT_NEAR(
        ValueOf(Face({100, 120, 30}, n), PlainTruth()), -kPretravel_mm, kNeglected_mm);
  }
}

TEST(BlindMachine, BacklashLagsAGaugeAndReadsMinusHalfOnEitherFace) {
  Truth truth = PlainTruth();
  truth.gap_mm[0] = 0.04;

  EXPECT_NEAR(
      ValueOf(Gauge({100, 150, 60}, Along(0), +1), truth), -0.02, kNeglected_mm);
  EXPECT_NEAR(
      ValueOf(Gauge({100, 150, 60}, Along(0), -1), truth), +0.02, kNeglected_mm);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(ValueOf(Face({100, 150, 10}, Along(0, side)), truth),
                -kPretravel_mm - 0.02,
                kNeglected_mm);
  }
}

TEST(BlindMachine, ATooLargeTipReadsPlus) {
  Truth truth = PlainTruth();
  truth.tip_radius_mm = 1.003;
  EXPECT_NEAR(ValueOf(Face({100, 150, 10}, Along(1, -1)), truth),
              0.003 - kPretravel_mm,
              kNeglected_mm);
}

TEST(BlindMachine, ATiltedTableIsHigherWhereItsSlopePoints) {
  Truth truth = PlainTruth();
  truth.bed_slope_x = 1e-4;
  // 100 mm right of the middle: 10 um higher; a side face 40 mm up leans back by 4 um.
  EXPECT_NEAR(
      ValueOf(Face({250, 150, 0}, Along(2)), truth), 0.010 - kPretravel_mm, 2e-7);
  EXPECT_NEAR(
      ValueOf(Face({150, 150, 40}, Along(0)), truth), -0.004 - kPretravel_mm, 2e-7);
}

TEST(BlindMachine, AMovedArtefactIsTouchedWhereItStands) {
  Plan plan;
  plan.stops = {Face({200, 150, 10}, Along(1))};
  plan.placements["s"] = {.center_mm = {150, 150, 0}};
  Truth truth = PlainTruth();
  truth.standing["s"] = {.offset_mm = {0, 0.3, 0}, .turn_rad = 1e-3};

  const auto readings = Machine(PlainDrawing(), truth).Perform(plan, {10});

  // Turned counter-clockwise, the point 50 mm right of the centre goes up by 50 um.
  const double second_order_mm = 2e-6;
  EXPECT_NEAR(readings[0].value_mm, 0.3 + 0.05 - kPretravel_mm, second_order_mm);
}

TEST(BlindMachine, ARingIsTouchedFromInside) {
  Stop stop = Face({180, 150, 10}, Along(0, -1));
  stop.ring_radius_mm = 30;
  EXPECT_NEAR(ValueOf(stop, PlainTruth()), -kPretravel_mm, kNeglected_mm);
}

TEST(BlindCauses, SquarenessTurnsRightHandedAboutItsFirstLetter) {
  const struct {
    const char* axis;
    Vector3 at;
    int along;
    double sign;
  } kHand[] = {{"C0Y", {150, 250, 60}, 0, -1},
               {"B0Z", {150, 150, 110}, 0, +1},
               {"A0Z", {150, 150, 110}, 1, -1}};
  for (const auto& hand : kHand) {
    const Defect defect = Made("squareness", hand.axis);
    const double arm_mm = hand.axis[0] == 'C' ? 100 : 50;
    EXPECT_NEAR(Adds_um(defect, Gauge(hand.at, Along(hand.along))),
                hand.sign * Parameter(defect, "angle_mrad") * arm_mm,
                kNear_um)
        << hand.axis;
  }
}

TEST(BlindCauses, AngularErrorsTurnRightHandedWithTheirLever) {
  // EBX at the far end of x, 50 mm above the middle: dx = + a z, a = slope / 2.
  const Defect pitch = Made("angular", "EBX");
  EXPECT_NEAR(Adds_um(pitch, Gauge({300, 150, 110}, Along(0))),
              0.5e-3 * Parameter(pitch, "slope_urad") * 50,
              kNear_um);
  // ECY at the far end of y, 100 mm to the right: dy = + a x.
  const Defect yaw = Made("angular", "ECY");
  EXPECT_NEAR(Adds_um(yaw, Gauge({250, 300, 60}, Along(1))),
              0.5e-3 * Parameter(yaw, "slope_urad") * 100,
              kNear_um);
  // EAY: dy = - a z.
  const Defect roll = Made("angular", "EAY");
  EXPECT_NEAR(Adds_um(roll, Gauge({150, 300, 110}, Along(1))),
              -0.5e-3 * Parameter(roll, "slope_urad") * 50,
              kNear_um);
}

TEST(BlindCauses, ASaggingBeamHangsLowerInItsMiddleAndProbesHigh) {
  const Defect defect = Made("gantry_sag", "EZX");
  const double middle_um = Adds_um(defect, Face({150, 150, 20}, Along(2)));
  const double end_um = Adds_um(defect, Face({295, 150, 20}, Along(2)));
  EXPECT_GT(middle_um - end_um, 0.6);
  EXPECT_LT(middle_um - end_um, 1.3);
}

TEST(BlindCauses, ATwistedBeamLiftsATipThatStandsOffInY) {
  const Defect defect = Made("axis_twist", "EAX");
  Stop far = Face({299, 150, 20}, Along(2));
  const double without_um = Adds_um(defect, far);
  far.offset_mm = {0, 40, 0};
  const double expected_um = -0.5 * Parameter(defect, "twist_mrad") * 40;
  EXPECT_NEAR(
      Adds_um(defect, far) - without_um, expected_um, 0.1 * std::abs(expected_um));
}

TEST(BlindCauses, ABowGoesToPlusAtBothEnds) {
  const Defect defect = Made("straightness", "EYX");
  const double sign = Parameter(defect, "bow_um");
  for (const double x_mm : {5.0, 295.0}) {
    EXPECT_GT(sign * (Adds_um(defect, Gauge({x_mm, 150, 60}, Along(1))) -
                      Adds_um(defect, Gauge({150, 150, 60}, Along(1)))),
              0.5);
  }
}

TEST(BlindCauses, AWaveIsAskedAtTheCommandedPositionOfTheTrigger) {
  Defect defect = Made("cyclic_lead", "x");
  defect.size = 5;
  Truth truth = PlainTruth();
  truth.defects = {defect};
  const double value_mm = ValueOf(Face({100.3, 150, 10}, Along(0)), truth);
  Instant at;
  at.q_mm[0] = 100.3 + value_mm + 1;  // nominal + (value + R_cfg) n
  EXPECT_NEAR(
      value_mm, -kPretravel_mm - defect.size * defect.motion(at)[0], kNeglected_mm);
}

TEST(BlindCauses, WearLoadAndSpikeLagBehindTheMotion) {
  const Defect worn = Made("backlash_worn", "x");
  const double center_mm = Parameter(worn, "center_mm");
  EXPECT_NEAR(Adds_um(worn, Gauge({center_mm, 150, 60}, Along(0))), -0.5, 0.01);
  EXPECT_NEAR(Adds_um(worn, Gauge({center_mm, 150, 60}, Along(0), -1)), 0.5, 0.01);

  const Defect windup = Made("windup_load", "x");
  Stop loaded = Gauge({150, 150, 60}, Along(0));
  loaded.load_n = 60;
  // 0.01 um/N times 60 N, half of it; at most 6 % stiffer.
  EXPECT_NEAR(Adds_um(windup, loaded), -0.3, 0.018);

  const Defect spike = Made("reversal_spike", "x");
  Stop turned = Gauge({150, 150, 60}, Along(0), -1);
  turned.via = {{200, 150, 60}, {149.5, 150, 60}};  // Then + by 0.5 mm.
  EXPECT_LT(Adds_um(spike, turned), -0.3);
  EXPECT_GT(Adds_um(spike, turned), -1);
}

TEST(BlindCauses, LatencyReadsMinusFeedTimesTime) {
  const Defect defect = Made("trigger_latency", "");
  Stop stop = Face({100, 150, 10}, Along(0));
  stop.feed_mm_s = 3;
  EXPECT_NEAR(Adds_um(defect, stop), -3.0, kNear_um);
}

TEST(BlindCauses, LobesFollowTheNormalAgainstTheSpindle) {
  const Defect defect = Made("probe_lobing", "");
  const double phase_rad = Parameter(defect, "phase_deg") * std::numbers::pi / 180;
  double first = 0;  // The fundamental, from four faces 30 degrees apart in 3 theta.
  for (int i = 0; i < 12; ++i) {
    const double theta_rad = i * std::numbers::pi / 6;
    Stop stop = Face({150, 150, 10}, {std::cos(theta_rad), std::sin(theta_rad), 0});
    stop.spindle_deg = 90;
    first += Adds_um(defect, stop) *
             std::cos(3 * (theta_rad - std::numbers::pi / 2) + phase_rad) / 6;
  }
  EXPECT_NEAR(first, -1.0, kNear_um);  // Pre-travel grows by A cos; touches read minus.
}

TEST(BlindCauses, ATipThatRunsOutTurnsWithTheSpindle) {
  const Defect defect = Made("tip_runout", "");
  const double phase_rad = Parameter(defect, "phase_deg") * std::numbers::pi / 180;
  Stop stop = Face({100, 150, 10}, Along(0));
  EXPECT_NEAR(Adds_um(defect, stop), -std::cos(phase_rad), kNear_um);
  stop.spindle_deg = 90;
  EXPECT_NEAR(Adds_um(defect, stop), std::sin(phase_rad), kNear_um);
}

TEST(BlindCauses, UnequalServosMakeAnEllipseThatFollowsTheSense) {
  const Defect defect = Made("servo_mismatch", "");
  const double mismatch_ms = Parameter(defect, "mismatch_ms");
  for (const double sense : {1.0, -1.0}) {
    Stop stop;
    stop.kind = Kind::kRadial;
    stop.circle_radius_mm = 100;
    stop.sense = sense;
    stop.feed_mm_s = 60;
    const double c = std::sqrt(0.5);
    stop.n = {c, c, 0};
    stop.at_mm = {150 + 100 * c, 150 + 100 * c, 0};
    // -sense v (tau_y - tau_x) / 2 sin(2 theta), theta = 45 degrees.
    EXPECT_NEAR(Adds_um(defect, stop), -sense * 60 * mismatch_ms / 2, 0.05);
  }
}

TEST(BlindCauses, TemperaturesActAsTheContractSays) {
  const double late_s = 7000;
  const Defect frame = Made("frame_temperature", "frame");
  EXPECT_LT(Parameter(frame, "growth_um_per_k") *
                Adds_um(frame, Face({150, 150, 20}, Along(2)), late_s),
            -1);  // It lifts the tool.
  const Defect bed = Made("frame_temperature", "bed");
  EXPECT_GT(Parameter(bed, "growth_um_per_k") *
                Adds_um(bed, Face({150, 150, 20}, Along(2)), late_s),
            1);
  const Defect probe = Made("probe_temperature", "");
  for (const double side : {-1.0, 1.0}) {
    EXPECT_LT(Parameter(probe, "drift_um_per_k") *
                  Adds_um(probe, Face({150, 150, 20}, Along(0, side)), late_s),
              -1);
  }
  // 1 um/(m K), 0.2 m from home, more than 3 K warmer.
  EXPECT_GT(
      Adds_um(Made("thermal_screw", "x"), Gauge({200, 150, 60}, Along(0)), late_s),
      0.6);
}

TEST(BlindCauses, AJumpLastsUntilTheNextHoming) {
  const Defect defect = Made("missed_steps", "x");
  const double jump_um = Parameter(defect, "jump_um");
  const double after_s = Parameter(defect, "at_t_s") + 50;
  Stop stop = Gauge({150, 150, 60}, Along(0));
  EXPECT_NEAR(Adds_um(defect, stop, after_s), jump_um, kNear_um);
  stop.rehome = true;
  EXPECT_NEAR(Adds_um(defect, stop, after_s), 0, kNear_um);
}

TEST(BlindCase, WithoutACauseTheBaselineExplainsEveryRow) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Case made;
    MakeCase({.kind = "null", .seed = seed, .clean = true}, &made);
    const auto readings =
        Machine(made.drawing, made.truth).Perform(made.plan, made.times_s);
    Column values;
    for (const Reading& reading : readings) values.push_back(reading.value_mm);
    const Column rest = Projector(BaselineColumns(made.plan, readings)).Rest(values);
    const double neglected_mm = 0.4e-3;  // Unequal pre-travels in a ring: an ellipse.
    for (const double value : rest) EXPECT_LT(std::abs(value), neglected_mm);
  }
}

TEST(BlindCase, ShowsItsCauseAsLargeAsAsked) {
  Case made;
  MakeCase({.kind = "single", .hidden = {{"gantry_sag", "EZX", 4}}, .seed = 9}, &made);
  EXPECT_NEAR(made.hidden[0].peak_sigma, 4, 0.05);
  EXPECT_GT(made.hidden[0].sum_squares, 100);
}

TEST(BlindCase, IsTheSameEveryTime) {
  Case first;
  Case second;
  MakeCase({.kind = "pair", .seed = 12}, &first);
  MakeCase({.kind = "pair", .seed = 12}, &second);
  ASSERT_EQ(first.readings.size(), second.readings.size());
  for (std::size_t i = 0; i < first.readings.size(); ++i) {
    EXPECT_EQ(first.readings[i].value_mm, second.readings[i].value_mm);
  }
  EXPECT_EQ(TruthJson(first), TruthJson(second));
}

}  // namespace
}  // namespace blind
