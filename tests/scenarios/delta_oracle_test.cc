#include "scenarios/kinds/delta_oracle.h"

#include <array>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/rrf_least_squares.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

Json Ask(DeltaOracle* oracle, const Json& asked) {
  return Json::parse(oracle->Answer(asked.dump()));
}

TEST(DeltaOracle, DescribesItsMachinesInTurn) {
  DeltaOracle oracle(2, 7);
  EXPECT_EQ(Ask(&oracle, {{"ask", "machine"}})["machine"], 1);
  const Json drawn = Ask(&oracle, {{"ask", "machine"}})["geometry"];
  EXPECT_EQ(drawn["angle_deg"], Json({210.0, 330.0, 90.0}));
  Ask(&oracle, {{"ask", "done"}, {"geometry", drawn}});
  EXPECT_EQ(Ask(&oracle, {{"ask", "machine"}})["machine"], 2);
  Ask(&oracle, {{"ask", "done"}, {"geometry", drawn}});
  EXPECT_EQ(Ask(&oracle, {{"ask", "machine"}})["over"], true);
  EXPECT_THAT(Ask(&oracle, {{"ask", "probe"}, {"x", 0}, {"y", 0}})["error"],
              HasSubstr("no machine left"));
}

Json GeometryOf(const DeltaModel<double>& model) {
  std::array<double, 3> angle_deg{};
  for (std::size_t i = 0; i < 3; ++i) angle_deg[i] = DegFromRad(model.angle_rad[i]);
  return {{"endstop_mm", model.endstop_mm},
          {"radius_mm", model.radius_mm},
          {"angle_deg", angle_deg},
          {"arm_mm", model.arm_mm}};
}

// As drawn is as bad as before; what a public engine makes of the same touches is as
// good as it is on RandomDelta.
TEST(DeltaOracle, ScoresByTheTruth) {
  DeltaOracle oracle(2, 7);
  const Json drawn = Ask(&oracle, {{"ask", "machine"}})["geometry"];
  const Json same = Ask(&oracle, {{"ask", "done"}, {"geometry", drawn}})["score"];
  EXPECT_NEAR(
      same["z_rms_um"].get<double>(), same["z_rms_before_um"].get<double>(), 1e-6);
  EXPECT_EQ(same["is_worse"], true);

  const DeltaProbe probe = [&](const DeltaModel<double>& settings,
                               double x_mm,
                               double y_mm) -> std::optional<Vec3<double>> {
    Ask(&oracle, {{"ask", "set"}, {"geometry", GeometryOf(settings)}});
    const Json touched = Ask(&oracle, {{"ask", "probe"}, {"x", x_mm}, {"y", y_mm}});
    return DeltaMotors_mm(settings, Vec3<double>(x_mm, y_mm, touched["z"]));
  };
  const DeltaOutcome outcome =
      CalibrateRrf(probe,
                   SymmetricDelta(300, 130, 250),
                   {.factors = 6, .points = RrfProbePoints(kCompareRadius_mm)});
  const Json score = Ask(
      &oracle, {{"ask", "done"}, {"geometry", GeometryOf(outcome.settings)}})["score"];
  EXPECT_EQ(score["touches"], 16);
  EXPECT_LT(score["z_rms_um"].get<double>(), 30);
  EXPECT_EQ(score["is_worse"], false);
}

// A geometry that is set says the same touch by other numbers: the middle, 1 mm lower.
TEST(DeltaOracle, TellsTouchesInTheGeometryThatIsSet) {
  DeltaOracle oracle(1, 7);
  const Json drawn = Ask(&oracle, {{"ask", "machine"}})["geometry"];
  const double before = Ask(&oracle, {{"ask", "probe"}, {"x", 0}, {"y", 0}})["z"];
  Ask(&oracle, {{"ask", "set"}, {"geometry", {{"endstop_mm", 301}}}});
  const double after = Ask(&oracle, {{"ask", "probe"}, {"x", 0}, {"y", 0}})["z"];
  EXPECT_NEAR(after - before, 1, 0.1);
}

TEST(DeltaOracle, RefusesWhatItCannotUnderstandAndGoesOn) {
  DeltaOracle oracle(1, 7);
  for (const char* const line : {"foo",
                                 "[]",
                                 "{}",
                                 R"({"ask": 3})",
                                 R"({"ask": "probe", "x": 1e99, "y": 0})",
                                 R"({"ask": "probe", "x": 101, "y": 0})",
                                 R"({"ask": "done"})",
                                 R"({"ask": "done", "geometry": {"radius": 1}})",
                                 R"({"ask": "set", "geometry": {"arm_mm": [1, 2]}})",
                                 "{\"ask\": \"\xff\"}"}) {
    EXPECT_TRUE(Json::parse(oracle.Answer(line)).contains("error")) << line;
  }
  EXPECT_EQ(oracle.errors(), 10);
  // No machine at all: nonsense, and said so.
  const Json score =
      Ask(&oracle, {{"ask", "done"}, {"geometry", {{"radius_mm", -5}}}})["score"];
  EXPECT_EQ(score["is_worse"], true);
}

}  // namespace
}  // namespace caltwin
