#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/firmware/grbl/controller.h"
#include "tests/firmware/rigid_plant.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

using Lines = std::vector<std::string>;

/// A grbl with a rigid machine at its motors; x and y home to their lower ends, z to
/// its upper one.
struct GrblBench {
  explicit GrblBench(double speed = std::numeric_limits<double>::infinity())
      : pace(speed),
        paced(&plant, &pace),
        grbl(machine, machine.settings, &paced, &pace, Motors::Zero(3)) {
    grbl.SwitchOn();
  }
  Lines Say(const std::string& line) { return grbl.Execute(line); }
  /// Says them all; each is answered by ok alone.
  void Do(const Lines& lines) {
    for (const std::string& line : lines) {
      EXPECT_THAT(Say(line), ElementsAre("ok")) << line;
    }
  }
  Vec3<double> Place() {
    while (grbl.has_moves()) grbl.GoOn();
    return grbl.machine_mm();
  }
  std::string Status() { return grbl.Status(128); }

  Machine machine = TestMachine();
  RigidPlant plant{machine};
  Pace pace;
  PacedPlant paced;
  grbl::Controller grbl;
};

TEST(Grbl, IsLockedUntilItIsHomed) {
  GrblBench bench;

  EXPECT_THAT(bench.grbl.SwitchOn(),
              ElementsAre("", "Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"));
  EXPECT_THAT(bench.Say("G0 X-1"), ElementsAre("error:9"));
  bench.Do({"$H"});
  EXPECT_THAT(bench.Status(), StartsWith("<Idle|MPos:-298.000,-298.000,-2.000|FS:0,0"));
}

// Machine zero is the upper end of each axis, wherever its switch is.
TEST(Grbl, MovesInItsOwnCoordinates) {
  GrblBench bench;
  bench.Do({"$H", "G90 G0 X-100 Y-50 Z-20", "G91 G1 X10 F600"});

  EXPECT_LT((bench.Place() - Vec3<double>(-90, -50, -20)).norm(), 1e-9);
  // The rigid machine's x is 0 at its lower end: 210 mm above it at 800 steps/mm.
  EXPECT_NEAR(bench.plant.steps[0], 210 * 800, 1e-6);
}

// As grbl's documentation numbers them.
TEST(Grbl, RefusesWithItsNumbers) {
  GrblBench bench;
  bench.Do({"$H"});
  const std::vector<std::pair<std::string, int>> cases = {{"10", 1},
                                                          {"G", 2},
                                                          {"G0 Xa", 2},
                                                          {"$foo", 3},
                                                          {"$200=1", 3},
                                                          {"$100=-1", 4},
                                                          {"G1 F-1", 4},
                                                          {"$0=1", 6},
                                                          {"G9", 20},
                                                          {"G5.1", 20},
                                                          {"M7", 20},
                                                          {"G0 A1", 20},
                                                          {"G0 G1 X-1", 24},
                                                          {"G90 G91", 21},
                                                          {"G1 X-1", 22},
                                                          {"G54.1", 23},
                                                          {"M3.5", 23},
                                                          {"G0 X-1 X-2", 25},
                                                          {"G92", 26},
                                                          {"G10 L2 P1", 26},
                                                          {"G4", 28},
                                                          {"G10 X0", 28},
                                                          {"G10 P1 X0", 20},
                                                          {"G10 L2 P9 X0", 29},
                                                          {"G53 G2 X-1 I1 F9", 30},
                                                          {"G80 X-1", 31},
                                                          {"G2 Z-1 I1 F9", 32},
                                                          {"G2 X-1 R0.1 F9", 34},
                                                          {"G2 X-1 F9", 35},
                                                          {"G0 X-1 P1", 36},
                                                          {"G43.1 X1", 37},
                                                          {"$J=X-1", 22},
                                                          {"$J=G0 X-1 F9", 16},
                                                          {"$J=X1 F9", 15}};
  for (const auto& [line, number] : cases) {
    EXPECT_THAT(bench.Say(line), ElementsAre("error:" + std::to_string(number)))
        << line;
  }
  EXPECT_THAT(bench.Say(std::string(100, '1')), ElementsAre("error:11"));
  EXPECT_THAT(bench.Say("$G"),
              ElementsAre("[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]", "ok"));
}

TEST(Grbl, BlanksCommentsAndSmallLettersDoNotCount) {
  GrblBench bench;
  bench.Do({"$H", "g90 (over there) g0x-1 0 ; ten", "", "( nothing )"});

  EXPECT_NEAR(bench.Place()[0], -10, 1e-9);
}

// The place is noted when the probe says so; what is past it, the machine has braked
// in: v^2 / 2a.
TEST(Grbl, ProbesAndBrakesBehind) {
  GrblBench bench;
  bench.Do({"$H"});
  bench.plant.wall_mm = 100;  // Of the drawing: -200 in grbl's coordinates.

  const Lines said = bench.Say("G38.2 X-10 F600");

  EXPECT_THAT(said, ElementsAre("[PRB:-200.000,-298.000,-2.000:1]", "ok"));
  const double braked_mm = 10.0 * 10.0 / (2 * 500);
  EXPECT_NEAR(bench.Place()[0], -200 + braked_mm, 1.0 / 800);
  EXPECT_THAT(bench.Status(), HasSubstr("|Pn:P"));
}

TEST(Grbl, ProbeThatFindsNothingIsAnAlarmOnlyWhereItMustFind) {
  GrblBench bench;
  bench.Do({"$H"});

  EXPECT_THAT(bench.Say("G38.3 X-200 F6000"),
              ElementsAre("[PRB:-200.000,-298.000,-2.000:0]", "ok"));
  EXPECT_THAT(bench.Say("G38.2 X-190 F6000"),
              ElementsAre("ALARM:5", "[PRB:-200.000,-298.000,-2.000:0]", "ok"));
  EXPECT_THAT(bench.Say("G0 X-1"), ElementsAre("error:9"));
  EXPECT_THAT(bench.Say("$X"), ElementsAre("[MSG:Caution: Unlocked]", "ok"));
  EXPECT_THAT(bench.Say("G38.4 X-180 F6000"), ElementsAre("ALARM:4", "ok"));
}

TEST(Grbl, SoftLimitNeedsAReset) {
  GrblBench bench;
  bench.Do({"$H"});

  EXPECT_THAT(bench.Say("G0 X1"), ElementsAre("ALARM:2", "[MSG:Reset to continue]"));
  EXPECT_EQ(bench.Status(), "");
  EXPECT_TRUE(bench.Say("$X").empty());
  bench.pace.Stop();
  EXPECT_THAT(bench.grbl.Reset(/*in_motion=*/false),
              ElementsAre("", "Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"));
  EXPECT_THAT(bench.Status(), StartsWith("<Alarm|MPos:-298.000"));
}

// Steps stay what they are when steps/mm change, so the place does not.
TEST(Grbl, NewStepsPerMmMoveTheCoordinate) {
  GrblBench bench;
  bench.Do({"$H", "G90 G0 X-100", "$100=400"});

  EXPECT_NEAR(bench.Place()[0], -200, 1e-9);
}

TEST(Grbl, ArcsStayOnTheirCircle) {
  GrblBench bench;
  bench.Do({"$H", "G90 G0 X-100 Y-100 Z-20"});
  bench.Place();
  bench.plant.segments.clear();
  bench.Do({"G2 X-80 Y-100 I10 J0 F1200"});
  bench.Place();

  ASSERT_GT(bench.plant.segments.size(), 30U);
  for (const Segment& segment : bench.plant.segments) {
    // Both ends in grbl's coordinates; the middle of each chord within $12, 2 um.
    const Vec3<double> middle = (segment.from_steps + segment.to_steps) / 1600;
    const double x_mm = middle[0] - 300 + 90, y_mm = middle[1] - 300 + 100;
    EXPECT_NEAR(std::hypot(x_mm, y_mm), 10, 0.002 + 1.0 / 800);
    EXPECT_GT(y_mm, -0.01);  // Clockwise from the left: over the top.
  }
}

TEST(Grbl, WorkplacesShiftAndLast) {
  GrblBench bench;
  bench.Do({"$H", "G0 X-100 Y-100", "G10 L20 P2 X0 Y5", "G55", "G92 X1", "G43.1 Z3"});

  EXPECT_THAT(bench.Status(), HasSubstr("WCO:-101.000,-105.000,3.000"));
  bench.pace.Stop();
  bench.grbl.Reset(false);
  EXPECT_THAT(bench.Say("$#"), testing::Contains("[G55:-100.000,-105.000,0.000]"));
  EXPECT_THAT(bench.Say("$#"), testing::Contains("[G92:0.000,0.000,0.000]"));
}

TEST(Grbl, InchesAndInverseTime) {
  GrblBench bench;
  bench.Do({"$H", "G20 G90 G0 X-2", "G93 G1 X-1 F60"});

  EXPECT_NEAR(bench.Place()[0], -25.4, 1.0 / 800);
  // 25.4 mm in a second.
  EXPECT_NEAR(bench.plant.segments.back().profile.feed_top_mm_s, 25.4, 0.01);
  EXPECT_THAT(bench.Say("G1 X-2"), ElementsAre("error:22"));
}

// Found by an independent review.
TEST(Grbl, ChecksAProgramWithoutMoving) {
  GrblBench bench;
  bench.Do({"$H"});
  EXPECT_THAT(bench.Say("$C"), ElementsAre("[MSG:Enabled]", "ok"));
  bench.Do({"G90 G0 X-10 Y-10", "G2 X-20 Y-10 I-5 J0 F100"});  // On its circle there.
  EXPECT_THAT(bench.Say("$H"), ElementsAre("error:8"));
  EXPECT_THAT(bench.Say("$J=X-5 F100"), ElementsAre("error:8"));
  EXPECT_THAT(bench.Say("G0 X5"), ElementsAre("ALARM:2", "[MSG:Reset to continue]"));
  EXPECT_NEAR(bench.Place()[0], -298, 1e-9);
}

TEST(Grbl, InverseTimeOfACircleIsItsOwnLength) {
  GrblBench bench;
  bench.Do({"$H", "G90 G0 X-100 Y-100 Z-20", "G91 G93 G2 X0 Y0 I5 J0 F60"});
  bench.Place();
  // 31.4 mm in a second; the jerk at the chords' corners allows it.
  EXPECT_NEAR(
      bench.plant.segments[bench.plant.segments.size() / 2].profile.feed_top_mm_s,
      31.4,
      0.2);
}

TEST(Grbl, SettingsThatNothingCouldMoveWithAreRefused) {
  GrblBench bench;
  for (const char* const line : {"$24=0", "$25=0", "$27=0", "$100=0", "$110=0"}) {
    EXPECT_THAT(bench.Say(line), ElementsAre("error:3")) << line;
  }
}

TEST(Grbl, AnswersOkBeforeItBeginsAnew) {
  GrblBench bench;
  bench.Do({"$H"});
  EXPECT_THAT(
      bench.Say("$RST=#"),
      ElementsAre("[MSG:Restoring defaults]", "ok", "", StartsWith("Grbl 1.1h")));
  EXPECT_THAT(bench.Say("$SLP"), ElementsAre("ok", "[MSG:Sleeping]"));
  EXPECT_TRUE(bench.Say("$G").empty());
  bench.pace.Stop();
  EXPECT_THAT(bench.grbl.Reset(false), testing::Contains("[MSG:'$H'|'$X' to unlock]"));
}

TEST(Grbl, OptionalStopDoesNotPause) {
  GrblBench bench;
  bench.Do({"$H", "M1"});
  EXPECT_THAT(bench.Say("M30"), ElementsAre("[MSG:Pgm End]", "ok"));
}

TEST(Grbl, RapidsGoAsTheirOverrideSays) {
  GrblBench bench;
  bench.Do({"$H"});
  bench.grbl.Override(0x97);  // A quarter of 100 mm/s.
  bench.Do({"G0 X-10"});
  bench.Place();
  EXPECT_NEAR(bench.plant.segments.back().profile.feed_top_mm_s, 25, 1e-6);
}

/// A thread that performs what waits, as the server's does.
template <typename Deed>
void While(GrblBench* bench, const Deed& deed) {
  std::thread performer([&] { bench->Place(); });
  deed();
  performer.join();
}

bool IsSoon(const std::function<bool()>& so) {
  for (int i = 0; i < 1000; ++i) {
    if (so()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

TEST(GrblTimed, StandsWhileItIsHeldAndGoesOn) {
  GrblBench bench(/*speed=*/200);
  bench.Do({"$H", "G90 G1 X-100 F600"});  // 19.8 s of its time.
  While(&bench, [&] {
    EXPECT_TRUE(IsSoon([&] { return bench.pace.is_moving(); }));
    bench.grbl.Hold();
    EXPECT_THAT(bench.Status(), StartsWith("<Hold:0|"));
    // It looks up every 20 ms.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const Motors held = bench.pace.steps();
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    EXPECT_EQ(bench.pace.steps(), held);
    EXPECT_LT(held[0], 200 * 800);
    bench.grbl.Resume();
  });
  EXPECT_NEAR(bench.Place()[0], -100, 1e-9);
}

TEST(GrblTimed, ResetInMotionStopsWhereItIs) {
  GrblBench bench(/*speed=*/100);
  bench.Do({"$H", "G90 G1 X-100 F600"});
  While(&bench, [&] {
    EXPECT_TRUE(IsSoon([&] { return bench.pace.steps()[0] > 50 * 800; }));
    EXPECT_TRUE(bench.grbl.InMotion());
    bench.pace.Stop();
  });
  EXPECT_THAT(
      bench.grbl.Reset(/*in_motion=*/true),
      ElementsAre(
          "ALARM:3", "", "Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"));
  const double stands_mm = bench.Place()[0];
  EXPECT_GT(stands_mm, -250);
  EXPECT_LT(stands_mm, -101);
  EXPECT_NEAR(bench.plant.steps[0], (stands_mm + 300) * 800, 1e-6);
}

TEST(GrblTimed, JogEndsWithoutAnAlarm) {
  GrblBench bench(/*speed=*/100);
  bench.Do({"$H", "$J=X-100 F600"});
  EXPECT_THAT(bench.Say("G0 X-1"), ElementsAre("error:9"));
  While(&bench, [&] {
    EXPECT_TRUE(IsSoon([&] { return bench.pace.steps()[0] > 20 * 800; }));
    bench.pace.Stop();
  });
  bench.grbl.EndJogs();
  EXPECT_THAT(bench.Status(), StartsWith("<Idle|"));
  EXPECT_LT(bench.Place()[0], -101);
  bench.Do({"G0 X-100"});
  EXPECT_NEAR(bench.Place()[0], -100, 1e-9);
}

}  // namespace
}  // namespace caltwin
