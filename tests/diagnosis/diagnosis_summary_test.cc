// A diagnosis in one sentence: what answers comes first, whatever the verdict's word
// is.

#include "calibration/diagnosis/diagnosis_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace caltwin {
namespace {

using Answer = DiagnosisSummary::Answer;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Diagnosis Determined() {
  Diagnosis diagnosis{.verdict = DiagnosisVerdict::kNone, .has_model = true};
  diagnosis.baseline = {{.name = "scale.x", .is_determined = true}};
  return diagnosis;
}

Fact Scale() {
  return {.id = "scale", .sentence = "X moves 1.002 times", .is_answer = true};
}

// "None" is of the catalogue's causes; that steps/mm are wrong is the answer all the
// same.
TEST(DiagnosisSummary, AFigureAnswersWhereNoCauseIsNamed) {
  Diagnosis diagnosis = Determined();
  diagnosis.facts.all = {{.id = "repeatability", .sentence = "it repeats"}, Scale()};
  diagnosis.facts.cannot = {"lost motion of X"};
  diagnosis.facts.next = {{.instrument = "dial", .sentence = "measure both ways"}};

  const DiagnosisSummary summary = SummaryOf(diagnosis, {});

  EXPECT_EQ(summary.answer, Answer::kFigure);
  EXPECT_EQ(summary.sentence, "X moves 1.002 times.");
  EXPECT_THAT(summary.found, ElementsAre("It repeats."));  // Not said twice.
  EXPECT_THAT(summary.cannot_tell, ElementsAre("Lost motion of X."));
  EXPECT_THAT(summary.to_do, ElementsAre("Measure both ways."));
}

TEST(DiagnosisSummary, WhatIsNotTheMachineComesBeforeAll) {
  Diagnosis diagnosis = Determined();
  diagnosis.facts.all = {Scale()};
  diagnosis.facts.not_the_machine = {"file", "the columns are exchanged"};

  const DiagnosisSummary summary = SummaryOf(diagnosis, {});

  EXPECT_EQ(summary.answer, Answer::kElsewhere);
  EXPECT_EQ(summary.sentence, "The columns are exchanged.");
  EXPECT_THAT(summary.found, Contains("X moves 1.002 times."));
}

TEST(DiagnosisSummary, NothingAndTooFewAreToldApart) {
  EXPECT_EQ(SummaryOf(Determined(), {}).answer, Answer::kNothing);
  Diagnosis open = Determined();
  open.baseline[0].is_determined = false;
  EXPECT_EQ(SummaryOf(open, {}).answer, Answer::kTooFew);
  EXPECT_THAT(SummaryOf(open, {}).found, IsEmpty());
}

// What a reader can use of rows that determine little comes in place of "too few".
TEST(DiagnosisSummary, RowsThatDetermineLittleSayWhatTheyDo) {
  Diagnosis open = Determined();
  open.baseline[0].is_determined = false;
  open.facts.cannot = {"steps/mm of X: one position"};
  EXPECT_EQ(SummaryOf(open, {}).sentence,
            "These rows do not determine what is wrong. Steps/mm of X: one position.");
  open.facts.all = {{.id = "repeatability", .sentence = "it repeats"},
                    {.id = "plane", .sentence = "it leans"}};
  EXPECT_EQ(SummaryOf(open, {}).sentence,
            "It leans. These rows are too few to tell more.");
  open.facts.all.push_back(
      {.id = "one_size", .figures = {{"change_um", 20}}, .sentence = "X is large"});
  open.facts.all.push_back(
      {.id = "one_size", .figures = {{"change_um", -50}}, .sentence = "Z is small"});
  EXPECT_EQ(SummaryOf(open, {}).sentence, "Z is small.");
  // A scale of which nothing says how sure it is.
  open.facts.all.push_back(
      {.id = "scale", .figures = {{"factor", 0.52}}, .sentence = "X moves half"});
  EXPECT_EQ(SummaryOf(open, {}).sentence, "X moves half.");
  EXPECT_EQ(SummaryOf(open, {}).answer, Answer::kTooFew);
  open.wander_um_per_sqrt_h = 3;
  EXPECT_THAT(SummaryOf(open, {}).sentence, HasSubstr("readings drift"));
}

// A bad reading is left out: it is the answer only where there is no other.
TEST(DiagnosisSummary, ABadReadingComesLast) {
  Diagnosis diagnosis = Determined();
  diagnosis.facts.all = {
      {.id = "outliers", .sentence = "row 18 is bad", .is_answer = true}};
  EXPECT_EQ(SummaryOf(diagnosis, {}).sentence, "Row 18 is bad.");
  diagnosis.facts.all.push_back(
      {.id = "twist", .sentence = "two corners are high", .is_answer = true});
  EXPECT_EQ(SummaryOf(diagnosis, {}).sentence, "Two corners are high.");
}

// Facts know no machine: what its file holds they show again, and it is no news.
TEST(DiagnosisSummary, WhatTheMachinesFileHoldsIsNoAnswer) {
  Diagnosis diagnosis = Determined();
  diagnosis.facts.all = {Scale()};
  diagnosis.is_extended = true;
  EXPECT_EQ(SummaryOf(diagnosis, {}).answer, Answer::kNothing);
  EXPECT_THAT(SummaryOf(diagnosis, {}).sentence,
              HasSubstr("what the machine's file holds"));
}

TEST(DiagnosisSummary, SmallerThanAskedForIsNoAnswer) {
  Diagnosis diagnosis = Determined();
  diagnosis.facts.all = {Scale()};
  diagnosis.min_effect_um = 20;
  EXPECT_THAT(SummaryOf(diagnosis, {}).sentence, HasSubstr("nothing of 20 um or more"));
}

TEST(DiagnosisSummary, RowsThatWereLeftOutAreSaid) {
  Diagnosis diagnosis = Determined();
  diagnosis.outlier_rows = {3, 7};
  EXPECT_THAT(SummaryOf(diagnosis, {}).sentence,
              HasSubstr("2 rows that fit nothing were left out."));
}

TEST(DiagnosisSummary, SeveralPossibleCausesAreNamedWithTheirProbabilities) {
  Diagnosis diagnosis = Determined();
  diagnosis.verdict = DiagnosisVerdict::kAmbiguous;
  diagnosis.findings = {
      {.cause = "cyclic_lead",
       .axis = "x",
       .probability = 0.62,
       .candidates = {{.cause = "cyclic_lead", .axis = "x", .probability = 0.62},
                      {.cause = "microstep", .axis = "x", .probability = 0.375},
                      {.cause = "pitch_map", .axis = "x", .probability = 0.005}}}};

  const DiagnosisSummary summary = SummaryOf(diagnosis, {});

  EXPECT_EQ(summary.answer, Answer::kCause);
  EXPECT_THAT(summary.sentence,
              testing::AllOf(HasSubstr("More than one cause is possible: "),
                             HasSubstr("(62 %) or "),
                             HasSubstr("(38 %)"),
                             testing::Not(HasSubstr("(1 %)"))));
  // A rival that could imitate it is named, however improbable.
  diagnosis.findings[0].candidates[2].structural = true;
  EXPECT_THAT(SummaryOf(diagnosis, {}).sentence, HasSubstr("(under 1 %)"));
  const auto json = SummaryJson(summary);
  EXPECT_EQ(json["answer"], "cause");
  EXPECT_EQ(json["sentence"], summary.sentence);
}

}  // namespace
}  // namespace caltwin
