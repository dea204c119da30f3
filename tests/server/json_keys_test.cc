#include "tools/server/json_keys.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

std::vector<ProblemFault> FaultsIn(const Json& body) {
  try {
    JsonKeys keys(body);
    keys.Number("fx", {1, 100, "pixels"});
    keys.Number("k1", {-1, 1}, 0);
    keys.Integer("rows", 2, 5, 3);
    keys.Bool("is_on", false);
    keys.Tuples("points", 2, 1, 3);
    keys.Done();
  } catch (const Problem& problem) {
    EXPECT_EQ(problem.status(), 422);
    return problem.faults();
  }
  return {};
}

TEST(JsonKeys, SoundBodiesHaveNoFaults) {
  EXPECT_TRUE(FaultsIn({{"fx", 7}, {"points", {{1, 2.5}}}}).empty());
  EXPECT_TRUE(
      FaultsIn(
          {{"fx", 7}, {"k1", 0.5}, {"rows", 5}, {"is_on", true}, {"points", {{1, 2}}}})
          .empty());
}

TEST(JsonKeys, EveryFaultIsToldWithItsPlace) {
  const auto faults = FaultsIn({{"fz", 7},
                                {"k1", "a"},
                                {"rows", 2.5},
                                {"is_on", 1},
                                {"points", {{1, 2, 3}, {1, "b"}}}});

  ASSERT_EQ(faults.size(), 7u);
  EXPECT_EQ(faults[0].pointer, "/fz");
  EXPECT_NE(faults[0].hint.find("did you mean 'fx'"), std::string::npos);
  EXPECT_EQ(faults[1].pointer, "/fx");
  EXPECT_EQ(faults[1].detail, "is missing");
  EXPECT_EQ(faults[2].pointer, "/k1");
  EXPECT_EQ(faults[3].pointer, "/rows");
  EXPECT_EQ(faults[4].pointer, "/is_on");
  EXPECT_EQ(faults[5].pointer, "/points/0");
  EXPECT_EQ(faults[6].pointer, "/points/1/1");
}

TEST(JsonKeys, RangesAreKept) {
  EXPECT_EQ(FaultsIn({{"fx", 0}, {"points", {{1, 2}}}}).size(), 1u);
  EXPECT_EQ(FaultsIn({{"fx", 1e300}, {"points", {{1, 2}}}}).size(), 1u);
  EXPECT_EQ(FaultsIn({{"fx", 7}, {"points", Json::array()}}).size(), 1u);
  EXPECT_EQ(FaultsIn({{"fx", 7}, {"points", {{1e9, 2}}}}).size(), 1u);
}

TEST(JsonKeys, AnObjectWithinTheBodyKnowsWhereItStands) {
  const Json inner{{"q", 1}};
  JsonKeys keys(inner, "/steps_per_mm");
  keys.Number("x", {.least = 1, .most = 2, .unit = "mm"}, 1);
  try {
    keys.Done();
    FAIL() << "q is no key";
  } catch (const Problem& problem) {
    EXPECT_EQ(problem.faults().at(0).pointer, "/steps_per_mm/q");
  }
}

TEST(JsonKeys, ABodyIsAnObject) {
  EXPECT_EQ(FaultsIn(Json::array()).size(), 1u);
  EXPECT_EQ(FaultsIn(nullptr).size(), 1u);
}

}  // namespace
}  // namespace caltwin
