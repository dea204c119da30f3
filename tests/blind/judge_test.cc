// The judge must not be kinder than the specification, nor stricter.

#include "tests/blind/judge.h"

#include <gtest/gtest.h>

#include "tests/blind/causes.h"
#include "tests/blind/figures.h"
#include "tests/blind/metamorphic.h"
#include "tests/blind/sets.h"

namespace blind {
namespace {

using nlohmann::json;

json HiddenCause(const char* cause, const char* axis, json covariates = json::array()) {
  return {{"cause", cause},
          {"axis", axis},
          {"parameters", {{{"name", "amplitude_um"}, {"value", 5.0}}}},
          {"peak_sigma", 5.0},
          {"sum_squares", 500.0},
          {"separation", json::object()},
          {"acceptable", json::array()},
          {"covariates", std::move(covariates)}};
}

json TruthOf(const char* kind, json causes) {
  return {{"kind", kind}, {"seed", 1}, {"causes", std::move(causes)}};
}

json Candidate(const char* cause,
               const char* axis,
               double probability,
               bool structural = false) {
  return {{"cause", cause},
          {"axis", axis},
          {"probability", probability},
          {"structural", structural}};
}

json Finding(const char* cause, const char* axis, const json& others = json::array()) {
  json finding = Candidate(cause, axis, 0.99);
  finding["candidates"] = json::array({Candidate(cause, axis, 0.99)});
  for (const json& other : others) finding["candidates"].push_back(other);
  finding["parameters"] = {{{"name", "amplitude_um"}, {"value", 5.3}, {"sd", 0.2}}};
  finding["covariates"] = {"x"};
  return finding;
}

json Answer(const char* verdict, json findings) {
  return {{"verdict", verdict}, {"findings", std::move(findings)}};
}

const json kWaveOnX = TruthOf("single", json::array({HiddenCause("cyclic_lead", "x")}));

TEST(Judge, TheRightNameOnTheRightAxisIsRight) {
  const auto judged = Judge(
      kWaveOnX, Answer("named", json::array({Finding("cyclic_lead", "x")})), nullptr);

  EXPECT_TRUE(judged.first_right);
  EXPECT_TRUE(judged.set_holds);
  EXPECT_TRUE(judged.findings[0].alone);
  EXPECT_EQ(judged.intervals, 1);
  EXPECT_EQ(judged.covered, 1);
}

TEST(Judge, TheRightNameOnTheWrongAxisIsWrong) {
  const auto judged = Judge(
      kWaveOnX, Answer("named", json::array({Finding("cyclic_lead", "y")})), nullptr);

  EXPECT_FALSE(judged.first_right);
  EXPECT_FALSE(judged.set_holds);
  EXPECT_FALSE(judged.findings[0].tolerable);
}

TEST(Judge, ACandidateHoldsTheTruthWithoutBeingNamed) {
  const json others = json::array({Candidate("cyclic_lead", "x", 0.2)});
  const auto judged =
      Judge(kWaveOnX,
            Answer("ambiguous", json::array({Finding("microstep", "x", others)})),
            nullptr);

  EXPECT_FALSE(judged.first_right);
  EXPECT_TRUE(judged.set_holds);
  EXPECT_FALSE(judged.findings[0].alone);
}

TEST(Judge, AnAxisIsIgnoredWhereTheCauseHasOnlyOne) {
  const json truth = TruthOf("single", json::array({HiddenCause("gantry_sag", "EZX")}));
  EXPECT_TRUE(
      Judge(truth, Answer("named", json::array({Finding("gantry_sag", "")})), nullptr)
          .first_right);
}

TEST(Judge, UnknownInTheRightVariableIsNoWrongMechanism) {
  const json truth =
      TruthOf("outside", json::array({HiddenCause("dead_spot", "x", {"q"})}));
  const auto right =
      Judge(truth, Answer("unknown", json::array({Finding("unknown", "x")})), nullptr);
  json elsewhere = Finding("unknown", "probe");
  elsewhere["covariates"] = {"temp"};
  const auto wrong = Judge(truth, Answer("unknown", json::array({elsewhere})), nullptr);

  EXPECT_TRUE(right.findings[0].tolerable);
  EXPECT_FALSE(wrong.findings[0].tolerable);
}

TEST(Judge, AnAnswerThatCannotBeReadIsNoAnswer) {
  EXPECT_FALSE(Judge(kWaveOnX, nullptr, nullptr).ran);
}

TEST(Figures, AnyFindingOnNullDataIsAnAlarm) {
  const json truth = TruthOf("null", json::array());
  const auto alarm =
      Judge(truth, Answer("unknown", json::array({Finding("unknown", "x")})), nullptr);
  const auto quiet = Judge(truth, Answer("none", json::array()), nullptr);

  const Figure figure = Figures({alarm, quiet, quiet, quiet})[0];

  EXPECT_EQ(figure.cases, 4);
  EXPECT_EQ(figure.hits, 1);
}

TEST(Figures, FailOnlyBeyondTheBinomialLimit) {
  // 60 nulls at 1 %: more than 4 alarms. 74 singles at 95 %: more than 11 wrong.
  EXPECT_FALSE((Figure{"", 4, 60, 0.01, 0, true}.IsBeyondChance()));
  EXPECT_TRUE((Figure{"", 5, 60, 0.01, 0, true}.IsBeyondChance()));
  EXPECT_FALSE((Figure{"", 74 - 11, 74, 0.95, 0, false}.IsBeyondChance()));
  EXPECT_TRUE((Figure{"", 74 - 12, 74, 0.95, 0, false}.IsBeyondChance()));
}

TEST(Metamorphic, AMirrorSwapsXAndYAndTurnsTheOtherWay) {
  const TextTable table = ParseTable("cmd_x_mm,cmd_y_mm,artefact_turn_deg\n1,2,90\n");

  const TextTable mirrored = Mirrored(table);

  EXPECT_EQ(ToText(mirrored), "cmd_y_mm,cmd_x_mm,artefact_turn_deg\n1,2,-90\n");
  EXPECT_EQ(ToText(Mirrored(mirrored)),
            "cmd_x_mm,cmd_y_mm,artefact_turn_deg\n1,2,90\n");
}

TEST(Sets, TheSecondHalfFollowsTheDate) {
  const auto today = MakeSet({}, 1, 20261121);
  const auto tomorrow = MakeSet({}, 1, 20261122);
  ASSERT_EQ(today.size(), 60U + 74 + 10 + 10 + 20 + 16);
  EXPECT_EQ(today[0].seed, tomorrow[0].seed);
  EXPECT_NE(today[59].seed, tomorrow[59].seed);
}

TEST(Sets, HideEveryCauseOfTheCatalogue) {
  std::vector<std::string> hidden;
  for (const CaseRequest& request : MakeSet({}, 1, 1)) {
    if (request.kind == "single") hidden.push_back(request.hidden[0].cause);
  }
  for (const Cause& cause : LibraryCauses()) {
    EXPECT_GE(std::ranges::count(hidden, cause.name), 2) << cause.name;
  }
}

// What no row tells apart is told by a set that holds it; what rows do tell apart must
// be named. Pairs of which the plan does not see one, or sees little, do not count.
TEST(Judge, OfPairsWhatATwinImitatesIsToldByItsSet) {
  json lean = HiddenCause("tower_lean", "a"), rod = HiddenCause("rod_mismatch", "c1");
  const json answer = Answer(
      "ambiguous",
      json::array({Finding("tower_lean", "a"),
                   Finding("rod_mismatch",
                           "c2",
                           json::array({Candidate("rod_mismatch", "c1", 0.3)}))}));
  const auto told = [&] {
    return Judge(TruthOf("pair", json::array({lean, rod})), answer, nullptr);
  };
  EXPECT_EQ(told().hidden_told, 1);
  rod["separation"]["rod_mismatch c2"] = 8.0;
  EXPECT_EQ(told().hidden_told, 2);
  EXPECT_EQ(told().hidden_named, 1);

  const auto both = [](const Judgement& judgement) {
    return Figures({judgement})[6];
  };
  EXPECT_EQ(both(told()).hits, 1);
  EXPECT_EQ(both(told()).cases, 1);
  rod["sum_squares"] = 50.0;
  EXPECT_EQ(both(told()).cases, 0);
  rod["sum_squares"] = 500.0;
  rod["peak_sigma"] = 1.5;
  EXPECT_EQ(both(told()).cases, 0);
}

}  // namespace
}  // namespace blind
