#include "tools/commands/kinds/bed_api.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "tests/tools/caltwin_process.h"
#include "tools/commands/kinds/simulated_printer.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

// A printer whose bed leans by 6 and -3 mm/m, and its API.
class BedApiTest : public testing::Test {
 protected:
  explicit BedApiTest(const std::filesystem::path& store = {}) : store_(store) {
    Start();
  }

  void Start() {
    routes_ = {};
    api_ = std::make_unique<BedApi>(
        &printer_, BedApi::Options{store_, "triple_z_printer"}, &seat_, &events_);
    api_->AddTo(&routes_);
  }

  HttpResponse Ask(const std::string& method,
                   const std::string& path,
                   const Json& body = {}) {
    HttpRequest request{.method = method,
                        .path = "/api/calibration" + path,
                        .headers = {{"content-type", "application/json"}},
                        .body = body.dump()};
    return AnswerOf(routes_.Find(&request), request);
  }
  Json Done(const std::string& method, const std::string& path, const Json& body = {}) {
    const HttpResponse response = Ask(method, path, body);
    EXPECT_EQ(response.status, 200) << response.body;
    return Json::parse(response.body);
  }

  static TwinOptions Leaning() {
    return {
        .machine = "triple_z_printer",
        .truth = Written("lean.yaml",
                         "effects: {bed_tilt: {slope_x_mrad: 6, slope_y_mrad: -3}}\n"),
        .fidelity = "fast"};
  }

  std::filesystem::path store_;
  SimulatedPrinter twin_{Leaning()};
  TripleZPrinter printer_{BenchOf(twin_.machine(), &twin_.link(), 0)};
  OperatorSeat seat_{};
  EventTopic events_{};
  Routes routes_{};
  std::unique_ptr<BedApi> api_{};
};

// The published manual example: its own formula gives 2.45, 0 and 1.33, not the 0, 2.45
// and 1.12 that it prints.
TEST_F(BedApiTest, GivenHeightsAreFittedByTheFormula) {
  const Json found =
      Done("POST",
           "/bed-tilt/probe",
           {{"probe_points", {{20, 20, 9.23}, {215, 20, 11.68}, {20, 215, 10.35}}},
            {"use_printer", false}});

  const double a = 2.45 / 195;
  const double b = 1.12 / 195;
  EXPECT_NEAR(found["plane_equation"]["a"], a, 1e-12);
  EXPECT_NEAR(found["plane_equation"]["b"], b, 1e-12);
  EXPECT_NEAR(found["plane_equation"]["c"], 9.23 - 20 * (a + b), 1e-9);
  EXPECT_NEAR(found["tilt_angles"]["tilt_x_degrees"], std::atan(a) * 180 / M_PI, 1e-9);
  EXPECT_NEAR(found["z_offsets"]["z1_mm"], 2.45, 1e-9);
  EXPECT_NEAR(found["z_offsets"]["z2_mm"], 0, 1e-9);
  EXPECT_NEAR(found["z_offsets"]["z3_mm"], 1.33, 1e-9);
  EXPECT_EQ(found["residual_mm"], 0);
  EXPECT_TRUE(found["uncertainty"].is_null());
  EXPECT_EQ(found["measured_points"], 3);
}

TEST_F(BedApiTest, ALeaningBedIsLevelledInOneRound) {
  const Json found = Done("POST", "/bed-tilt/calibrate", {{"grid_rows", 3}});
  Done("POST", "/bed-tilt/apply-triple-z", found["z_offsets"]);
  const Json now = Done("POST", "/bed-tilt/calibrate", Json::object());

  EXPECT_NEAR(found["plane_equation"]["a"], 6e-3, 2e-5);
  EXPECT_NEAR(found["plane_equation"]["b"], -3e-3, 2e-5);
  const double counted = 0.00125 / 195;  // Whole steps of the screws.
  EXPECT_NEAR(now["plane_equation"]["a"], 0, 4 * counted);
  EXPECT_NEAR(now["plane_equation"]["b"], 0, 4 * counted);
  EXPECT_THAT(now["notes"].dump(), HasSubstr("the bed is level"));
}

TEST_F(BedApiTest, TheSameOffsetsMoveOnceAndNoughtTakesThemBack) {
  const Json found = Done("POST", "/bed-tilt/calibrate", Json::object());
  Done("POST", "/bed-tilt/apply-triple-z", found["z_offsets"]);
  const Json again = Done("POST", "/bed-tilt/apply-triple-z", found["z_offsets"]);
  const Json back = Done(
      "POST", "/bed-tilt/apply-triple-z", {{"z1_mm", 0}, {"z2_mm", 0}, {"z3_mm", 0}});

  EXPECT_NEAR(again["moved"]["z1_mm"], 0, 1e-9);
  EXPECT_NEAR(back["moved"]["z1_mm"], -found["z_offsets"]["z1_mm"].get<double>(), 1e-9);
}

TEST_F(BedApiTest, ValidationHoldsPointsAgainstThePlaneAsItStands) {
  Done("POST",
       "/bed-tilt/probe",
       {{"probe_points", {{0, 0, 1}, {100, 0, 1}, {0, 100, 1}, {100, 100, 1}}},
        {"use_printer", false}});

  const Json result = Done(
      "POST", "/validate", {{"test_points", {{1, 1, 1.1}, {2, 2, 0.7}, {3, 3, 1.2}}}});

  EXPECT_NEAR(result["mean_error_mm"], 0.2, 1e-12);
  EXPECT_NEAR(result["max_error_mm"], 0.3, 1e-12);
  EXPECT_NEAR(result["std_error_mm"], std::sqrt(0.02 / 3), 1e-9);  // Of 0.1, 0.3, 0.2.
  EXPECT_NEAR(result["mean_signed_error_mm"], 0, 1e-12);
  EXPECT_EQ(result["num_points"], 3);
}

TEST_F(BedApiTest, HeightsOverAnotherZeroAreNoTilt) {
  Done("POST",
       "/bed-tilt/probe",
       {{"probe_points", {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}}},
        {"use_printer", false}});

  const Json result =
      Done("POST", "/validate", {{"test_points", {{1, 1, 10}, {9, 9, 10.01}}}});

  EXPECT_THAT(result["notes"].dump(), HasSubstr("over another zero, not tilt"));
}

TEST_F(BedApiTest, WhatCannotBeIsRefusedBeforeAnythingMoves) {
  const auto status = [&](const char* path, const Json& body) {
    return Ask("POST", path, body).status;
  };
  const Json on_a_line = {{"probe_points", {{20, 20}, {30, 30}, {40, 40}}}};
  const Json outside = {{"probe_points", {{20, 20}, {900, 30}, {40, 10}}}};

  EXPECT_EQ(status("/bed-tilt/probe", on_a_line), 422);
  EXPECT_EQ(status("/bed-tilt/probe", outside), 422);
  EXPECT_EQ(status("/bed-tilt/probe", {{"probe_points", {{20, 20, 1}}}}), 422);
  EXPECT_EQ(
      status("/bed-tilt/apply-triple-z", {{"z1_mm", 0}, {"z2_mm", 11}, {"z3_mm", 0}}),
      422);
  EXPECT_EQ(status("/bed-tilt/apply-triple-z", {{"z1_mm", 0}}), 422);
  EXPECT_EQ(status("/bed-tilt/calibrate", {{"grid_rows", 1}}), 422);
  EXPECT_EQ(status("/validate", {{"test_points", {{1, 1, 1}}}}), 409);
  EXPECT_EQ(printer_.touches(), 0);
}

// Homing squares the screws: the page must not go on saying that the bed is level.
TEST_F(BedApiTest, HomingUndoesWhatWasApplied) {
  const Json found = Done("POST", "/bed-tilt/calibrate", Json::object());
  Done("POST", "/bed-tilt/apply-triple-z", found["z_offsets"]);
  EXPECT_NEAR(Done("GET", "/bed-tilt/current")["plane_now"]["a"], 0, 1e-4);

  ASSERT_TRUE(printer_.Home());

  const Json now = Done("GET", "/bed-tilt/current");
  EXPECT_TRUE(now["applied"].is_null());
  EXPECT_NEAR(now["plane_now"]["a"], 6e-3, 1e-4);
  EXPECT_THAT(now["notes"].dump(), HasSubstr("homed since"));
  EXPECT_FALSE(Done("GET", "/bed-tilt/status")["is_applied"]);
}

TEST_F(BedApiTest, AbortSaysWhetherSomethingWasAtWork) {
  EXPECT_EQ(Ask("POST", "/bed-tilt/abort").status, 202);
  EXPECT_FALSE(Json::parse(Ask("POST", "/bed-tilt/abort").body)["aborted"]);
  const auto seat = seat_.Take({}, "probing the bed");
  EXPECT_TRUE(Json::parse(Ask("POST", "/bed-tilt/abort").body)["aborted"]);
  EXPECT_TRUE(seat_.is_aborted());
}

TEST_F(BedApiTest, PointsTooCloseTogetherSpanNoPlane) {
  const auto given = [](double apart_mm) {
    return Json{{"probe_points", {{0, 0, 0}, {apart_mm, 0, 0.1}, {0, apart_mm, 0.1}}},
                {"use_printer", false}};
  };

  EXPECT_EQ(Ask("POST", "/bed-tilt/probe", given(1)).status, 422);
  EXPECT_EQ(Ask("POST", "/bed-tilt/probe", given(100)).status, 200);
}

TEST_F(BedApiTest, ANameIsCutBetweenLetters) {
  const HttpRequest other{
      .headers = {{"x-operator", std::string(59, 'a') + "\u00e9\u00e9"}}};
  const auto seat = seat_.Take(other, "probing the bed");

  EXPECT_EQ(
      Json::parse(Ask("POST", "/bed-tilt/calibrate", Json::object()).body)["held_by"],
      std::string(59, 'a'));
}

TEST_F(BedApiTest, WhoSitsThereIsNamed) {
  const HttpRequest other{.headers = {{"x-operator", "Ada"}}};
  const auto seat = seat_.Take(other, "probing the bed");

  const HttpResponse refused = Ask("POST", "/bed-tilt/calibrate", Json::object());

  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(Json::parse(refused.body)["held_by"], "Ada");
}

// Raising what the formula says makes a bed with exchanged motors worse; the next
// measurement names them.
TEST(BedApiOfSwappedMotors, TheNextMeasurementNamesThem) {
  SimulatedPrinter twin(
      {.machine = "triple_z_printer",
       .truth = Written("swapped.yaml",
                        "effects: {bed_tilt: {slope_x_mrad: 6, "
                        "slope_y_mrad: -3}, motors_swapped.z1z2: {}}\n"),
       .fidelity = "fast"});
  TripleZPrinter printer(BenchOf(twin.machine(), &twin.link(), 0));
  OperatorSeat seat;
  EventTopic events;
  BedApi api(&printer, {}, &seat, &events);
  Routes routes;
  api.AddTo(&routes);
  const auto ask = [&](const char* path, const Json& body) {
    HttpRequest request{.method = "POST",
                        .path = std::string("/api/calibration/bed-tilt/") + path,
                        .headers = {{"content-type", "application/json"}},
                        .body = body.dump()};
    return Json::parse(AnswerOf(routes.Find(&request), request).body);
  };

  ask("apply-triple-z", ask("calibrate", Json::object())["z_offsets"]);
  const Json after = ask("calibrate", Json::object());

  EXPECT_THAT(after["notes"].dump(), HasSubstr("z1 and z2 are exchanged"));
}

// What one printer with this truth answers to a calibration by 3x3 touches.
Json Calibrated(const TwinOptions& options) {
  SimulatedPrinter twin(options);
  TripleZPrinter printer(BenchOf(twin.machine(), &twin.link(), 0));
  OperatorSeat seat;
  EventTopic events;
  BedApi api(&printer, {}, &seat, &events);
  Routes routes;
  api.AddTo(&routes);
  HttpRequest request{.method = "POST",
                      .path = "/api/calibration/bed-tilt/calibrate",
                      .headers = {{"content-type", "application/json"}},
                      .body = "{}"};
  return Json::parse(AnswerOf(routes.Find(&request), request).body);
}

// The same sentences as `caltwin run`: the place is touched again.
TEST(BedApiOfTroubles, DebrisIsToldFromABentBed) {
  const std::string chip = Calibrated({.machine = CALTWIN_SOURCE_DIR
                                       "/examples/machines/chip_on_the_bed.yaml",
                                       .fidelity = "fast"})["notes"]
                               .dump();
  const std::string bent =
      Calibrated(
          {.machine = "triple_z_printer",
           .truth = Written("bent.yaml", "effects: {bed_bowl: {height_um: 900}}\n"),
           .fidelity = "fast"})["notes"]
          .dump();

  EXPECT_THAT(chip, HasSubstr("debris on the bed, not the probe"));
  EXPECT_THAT(bent, HasSubstr("the bed is bent by"));
  EXPECT_THAT(bent, Not(HasSubstr("debris")));
}

// Tilted both ways, its first corner stands 7 mm up.
TEST(BedApiOfTroubles, ATouchThatCannotBeginSaysWhy) {
  const Json said =
      Calibrated({.machine = "triple_z_printer",
                  .truth = Written(
                      "high.yaml",
                      "effects: {bed_tilt: {slope_x_mrad: -36, slope_y_mrad: -36}}\n"),
                  .fidelity = "fast"});

  EXPECT_EQ(said["status"], 409);
  EXPECT_THAT(said["errors"].dump(), HasSubstr("stands too high at (20, 20)"));
}

class BedApiOnDisk : public BedApiTest {
 protected:
  BedApiOnDisk() : BedApiTest(Scratch() / "bed.json") {}
};

TEST_F(BedApiOnDisk, WhatWasFoundOutlivesTheServer) {
  Done("POST",
       "/intrinsics",
       {{"fx", 901}, {"fy", 902}, {"cx", 640}, {"cy", 480}, {"k1", 0.1}});
  Done("POST", "/bed-tilt/calibrate", Json::object());
  const Json before = Done("GET", "/bed-tilt/current");

  Start();

  Json after = Done("GET", "/bed-tilt/current");
  EXPECT_EQ(after["points"], before["points"]);
  EXPECT_EQ(after["z_offsets"], before["z_offsets"]);
  EXPECT_EQ(Done("GET", "/intrinsics")["fx"], 901);
  EXPECT_EQ(Done("GET", "/intrinsics")["source"], "stored");
}

// What became of raised screws nobody knows after a start.
TEST_F(BedApiOnDisk, WhatWasAppliedIsNotTakenForGranted) {
  const Json found = Done("POST", "/bed-tilt/calibrate", Json::object());
  Done("POST", "/bed-tilt/apply-triple-z", found["z_offsets"]);

  Start();

  EXPECT_TRUE(Done("GET", "/bed-tilt/current")["applied"].is_null());
  EXPECT_THAT(Done("GET", "/bed-tilt/current")["notes"].dump(),
              HasSubstr("started anew"));
}

TEST_F(BedApiOnDisk, AnyCutOfTheFileIsPutAside) {
  Done("POST", "/bed-tilt/calibrate", Json::object());
  const std::string whole = ReadTextFile(store_, kLargestFile_bytes);
  for (std::size_t cut = 0; cut < whole.size() - 1; cut += 97) {
    WriteTextFile(store_, whole.substr(0, cut));
    Start();
    EXPECT_EQ(Ask("GET", "/bed-tilt/current").status, 404) << cut;
    EXPECT_THAT(api_->note(), HasSubstr("put aside"));
  }
}

}  // namespace
}  // namespace caltwin
