#include <chrono>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "sim/effects/drive.h"
#include "sim/effects/injected.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/kinds/perform.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"
#include "sim/twin/built.h"
#include "sim/twin/physics_plant.h"
#include "sim/twin/twin.h"

namespace caltwin {
namespace {

Machine Printer() {
  return ReadMachine(FindMachine("corexy_printer", ".", {}));
}

Injected Of(const std::string& effect, const std::string& axis, double value) {
  const Machine machine = Printer();
  Injected injected = NeutralEffect(*FindEffect(effect), axis, machine);
  injected.values[0] = value;
  return injected;
}

// Read along n, the motors having come in these senses.
Row RowAt(const Vec3<double>& q_mm,
          const Vec3<double>& n,
          double dir_a = 0,
          double dir_b = 0) {
  Row row{.row = 1, .campaign = "c"};
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    row.cmd_mm[k] = q_mm[i];
    row.n[k] = n[i];
    row.dir[k] = 0;
  }
  row.motor_dir = {dir_a, dir_b, kUnknown};
  return row;
}

double Predicted_mm(const Row& row, const std::vector<Injected>& effects) {
  const Machine machine = Printer();
  return Predict_mm<double>(machine, AtOf(row, machine, machine.settings), effects);
}

const Vec3<double> kX = Vec3<double>::UnitX(), kY = Vec3<double>::UnitY();
const Vec3<double> kPlace_mm(110, 70, 50);

// x = (a + b) / 2, y = (a - b) / 2: what one belt does wrong, half of it shows along
// each axis, along y with the sign of its belt.
TEST(CoreXy, ABeltActsAlongItsDiagonal) {
  const double ppm = 1000;
  const double a_mm = kPlace_mm[0] + kPlace_mm[1], b_mm = kPlace_mm[0] - kPlace_mm[1];
  const auto a = {Of("belt_pitch", "a", ppm)}, b = {Of("belt_pitch", "b", ppm)};

  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX), a), a_mm * 1e-3 / 2, 1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kY), a), a_mm * 1e-3 / 2, 1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX), b), b_mm * 1e-3 / 2, 1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kY), b), -b_mm * 1e-3 / 2, 1e-12);
}

TEST(CoreXy, StepsPerMmAreTheBelts) {
  const auto a = {Of("steps_per_mm", "a", 320 / 1.001)};
  const double a_mm = kPlace_mm[0] + kPlace_mm[1];
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX), a), a_mm * 1e-3 / 2, 1e-9);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kY), a), a_mm * 1e-3 / 2, 1e-9);
}

TEST(CoreXy, PlayLagsBehindItsOwnMotor) {
  const auto b = {Of("backlash", "b", 0.1)};
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX, 1, 1), b), -0.025, 1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kY, 1, -1), b), -0.025, 1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX, 1, 0), b), 0, 1e-12);
}

TEST(CoreXy, ARackedBeamTurnsAboutItsMiddle) {
  const auto racked = {Of("racking", "", 2)};
  const double from_middle_mm = kPlace_mm[0] - 150;
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kY), racked),
              std::sin(2e-3) * from_middle_mm,
              1e-12);
  EXPECT_NEAR(Predicted_mm(RowAt(kPlace_mm, kX), racked),
              (std::cos(2e-3) - 1) * from_middle_mm,
              1e-12);
}

// Every effect that only such a machine has, read in MuJoCo and by its closed form.
TEST(CoreXy, PhysicsAgreesWithTheClosedForms) {
  const std::vector<Injected> effects = {Of("backlash", "a", 0.05),
                                         Of("backlash", "b", 0.02),
                                         Of("belt_pitch", "b", 800),
                                         Of("pulley_eccentric", "a", 30),
                                         Of("microstep", "b", 8),
                                         Of("racking", "", 1.5)};
  std::vector<Row> rows;
  for (const double sense : {1.0, -1.0}) {
    for (const Vec3<double>& n : {kX, kY}) {
      rows.push_back(RowAt(kPlace_mm, n, sense, sense));
      rows.push_back(RowAt(kPlace_mm, n, sense, -sense));
      rows.push_back(RowAt(kPlace_mm, n, sense, 0));
    }
  }
  PerformConfig config{.machine = Printer(), .effects = effects, .is_noisy = false};
  const RowTable physics = Perform(config, rows);
  config.fidelity = Fidelity::kFast;
  const RowTable fast = Perform(config, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(physics.rows[i].value_mm, fast.rows[i].value_mm, 5e-4) << i;
    EXPECT_GT(std::abs(fast.rows[i].value_mm), 1e-3) << i;
  }
}

// RepRapFirmware's words: M92 X is motor A's, Count is in motor steps, and after a
// homing of both the axes stand where they were.
TEST(CoreXy, TheControllerCountsInMotors) {
  Twin twin({.machine = Printer(),
             .settings = Printer().settings,
             .fidelity = Fidelity::kFast});
  const auto send = [&](const std::string& line) {
    const auto reply = twin.link().Send(line, std::chrono::milliseconds(1000));
    EXPECT_TRUE(reply) << line;
    return reply && !reply->empty() ? reply->front() : std::string();
  };
  send("G28");
  send("G1 X100 Y30 F6000");
  EXPECT_NE(send("M114").find("Count 41600 22400 "), std::string::npos);
  const Vec3<double> tip_mm = twin.TipPosition_mm();
  EXPECT_NEAR(tip_mm[0], 100, 1e-9);
  EXPECT_NEAR(tip_mm[1], 30, 1e-9);
  send("M92 X321");
  EXPECT_EQ(twin.settings().steps_per_mm[0], 321);
  send("G28 X");
  EXPECT_NE(send("M114").find("X:0.000 Y:30.000"), std::string::npos);
}

// Of the belts A alone has play, so B pulls the head: along the rail that rubs less.
// Free space must not be jumped by a rule that does not know that.
TEST(CoreXy, PlayFollowsTheEasierRail) {
  Machine machine = Printer();
  machine.axes[0].rail_friction_n = 2;
  machine.axes[1].rail_friction_n = 14;
  Built built{.machine = machine, .effects = {Of("backlash", "a", 0.1)}};
  built.Prepare();
  PhysicsPlant plant(built, 1, 0);
  const auto go = [&](const Vec3<double>& by_mm) {
    Segment segment{.from_steps = plant.steps()};
    segment.to_steps = segment.from_steps +
                       DrivesOf(built.drives(), by_mm).cwiseProduct(built.steps_per_mm);
    segment.profile = {
        .length_mm = by_mm.norm(), .feed_top_mm_s = 5, .acceleration_mm_s2 = 100};
    plant.Run(segment, Watch{});
    return plant.Tip_mm();
  };
  const Vec3<double> before_mm = go({2, 2, 0});
  const Vec3<double> moved_mm = go({-2, 0, 0}) - before_mm;
  EXPECT_NEAR(moved_mm[0], -2, 1e-3);
  EXPECT_NEAR(moved_mm[1], 0, 1e-3);
}

// Where a gap is in one belt alone, the other pulls the head askew until it is taken
// up.
TEST(CoreXy, BothFidelitiesMoveAlike) {
  for (const Fidelity fidelity : {Fidelity::kFast, Fidelity::kPhysics}) {
    Twin twin({.machine = Printer(),
               .effects = {Of("backlash", "a", 0.1)},
               .settings = Printer().settings,
               .fidelity = fidelity});
    const auto send = [&](const std::string& line) {
      EXPECT_TRUE(twin.link().Send(line, std::chrono::milliseconds(1000))) << line;
    };
    send("G28");
    send("G1 X100 Y100 F6000");
    send("G1 X150 Y150 F6000");
    send("M400");
    const Vec3<double> up_mm = twin.TipPosition_mm();
    send("G1 X200 Y200 F6000");
    send("G1 X150 Y150 F6000");
    send("M400");
    const Vec3<double> apart_mm = twin.TipPosition_mm() - up_mm;
    EXPECT_NEAR(apart_mm[0], 0.05, 2e-3) << ToString(fidelity);
    EXPECT_NEAR(apart_mm[1], 0.05, 2e-3) << ToString(fidelity);
  }
}

}  // namespace
}  // namespace caltwin
