#include "calibration/diagnosis/diagnosis_text.h"

#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StrEq;

Finding CyclicX() {
  return {.cause = "cyclic_lead",
          .axis = "x",
          .probability = 0.998,
          .candidates = {{"cyclic_lead", "x", 0.998, false},
                         {"pitch_progressive", "x", 0.001, false}},
          .parameters = {{"amplitude_um", 5.63, 0.21},
                         {"phase_deg", 40, 3},
                         {"period_mm", 8, 0.001}},
          .share = 0.62};
}

Diagnosis TwoFindings() {
  Diagnosis diagnosis{
      .verdict = DiagnosisVerdict::kNamed,
      .findings = {CyclicX(), CyclicX()},
      .gain = {
          .blocks = {.before_mm = 0.0052, .after_mm = 0.0013, .rows = 84, .groups = 5},
          .noise_floor_mm = 0.0012,
          .explained_fraction = 0.99}};
  diagnosis.findings[1].axis = "y";
  diagnosis.findings[1].share = 0.37;
  return diagnosis;
}

Row Along(double x, double y) {
  Row row;
  row.n = {x, y, 0};
  return row;
}

TEST(DiagnosisText, SaysAFindingAsTheIssueDoes) {
  const Diagnosis diagnosis = TwoFindings();

  EXPECT_THAT(
      FindingText(diagnosis.findings[0], diagnosis, "X"),
      StrEq("The X screw errs by 5.6 +- 0.2 um once per turn (8.00 mm): 62 % of what "
            "the model could not explain; nothing else fits (next best 0.1 %). "
            "Correcting it takes X from 5.2 to 3.3 um on data it has not seen; all "
            "findings together to 1.3; the noise floor is 1.2."));
}

TEST(DiagnosisText, OfOneFindingSaysWhatWasHeldOutNotTheShare) {
  Diagnosis diagnosis = TwoFindings();
  diagnosis.findings.pop_back();

  const std::string text = FindingText(diagnosis.findings[0], diagnosis, "X");

  EXPECT_THAT(text, HasSubstr("from 5.2 to 1.3 um"));
  EXPECT_THAT(text, Not(HasSubstr("together")));
}

TEST(DiagnosisText, SaysWhatToMeasureNextAsAPlanHasIt) {
  Diagnosis diagnosis = TwoFindings();
  diagnosis.next_campaign = {.kind = "straightedge",
                             .options = {{"axis", "y"}},
                             .separates = {"angular", "straightness"},
                             .minutes = 5.2};
  EXPECT_THAT(DiagnosisText(diagnosis, {}),
              HasSubstr("Measure next: straightedge {axis: y} (6 minutes); it tells "
                        "angular and straightness apart.\n"));
  diagnosis.next_campaign->options.clear();
  diagnosis.next_campaign->separates = {"unknown"};
  EXPECT_THAT(DiagnosisText(diagnosis, {}),
              HasSubstr("Measure next: straightedge (6 minutes); a minute of it shows "
                        "most of the shape without a name.\n"));
}

// Of every cause that a diagnosis may name, on every axis it may have.
TEST(DiagnosisText, EveryNameIsASentence) {
  for (const Effect* one : AllEffects()) {
    const Effect& effect = *one;
    if (!effect.sight) continue;
    std::set<std::string_view> axes(effect.axes.begin(), effect.axes.end());
    for (const MachineKind* kind : {DeltaKind(), TripleZKind()}) {
      const auto own = AxesOn(effect, kind);
      axes.insert(own.begin(), own.end());
    }
    for (const std::string_view axis : axes) {
      Finding finding{.cause = std::string(effect.name), .axis = std::string(axis)};
      for (const Parameter& p : effect.parameters) {
        finding.parameters.push_back({std::string(p.name), 5, 0.1});
      }
      const std::string name = NameInWords(finding.cause, axis);
      const std::string does = WhatItDoes(finding);
      SCOPED_TRACE(name + " | " + does);
      EXPECT_THAT(name, HasSubstr(" "));  // Words, not the name of a key.
      EXPECT_THAT(name, Not(HasSubstr("  ")));
      EXPECT_FALSE(name.ends_with(' '));
      EXPECT_THAT(does, Not(HasSubstr("  ")));
      EXPECT_THAT(does, Not(HasSubstr("unknown amount")));
      EXPECT_FALSE(does.starts_with(finding.cause));
    }
  }
}

TEST(DiagnosisText, WritesNoPowersOfTen) {
  EXPECT_EQ(TwoDigits(0.0371), "0.037");
  EXPECT_EQ(TwoDigits(15.4), "15");
  EXPECT_EQ(TwoDigits(99.7), "100");
  EXPECT_EQ(TwoDigits(-1349), "-1300");
  EXPECT_EQ(TwoDigits(40321), "40000");
}

TEST(DiagnosisText, NoneOfTooFewRowsSaysSo) {
  Diagnosis diagnosis;
  diagnosis.baseline = {{.name = "scale.x", .unit = "ppm", .is_determined = false}};
  EXPECT_THAT(DiagnosisText(diagnosis, {}), HasSubstr("too few to tell anything"));
  diagnosis.wander_um_per_sqrt_h = 5;
  EXPECT_THAT(DiagnosisText(diagnosis, {}), HasSubstr("The readings drift"));
  diagnosis.wander_um_per_sqrt_h = 0;
  diagnosis.baseline.push_back({.name = "backlash.x", .unit = "mm"});
  EXPECT_THAT(DiagnosisText(diagnosis, {}), HasSubstr("there is only noise"));
}

TEST(DiagnosisText, NoneBesideAWanderSaysSo) {
  Diagnosis diagnosis;
  EXPECT_THAT(DiagnosisText(diagnosis, {}), HasSubstr("there is only noise."));
  diagnosis.wander_um_per_sqrt_h = 5;
  const std::string text = DiagnosisText(diagnosis, {});
  EXPECT_THAT(text, HasSubstr("there is only a slow wander and noise."));
  EXPECT_THAT(text, HasSubstr("Slow wander of 5 um per root hour"));
}

TEST(DiagnosisText, AStructuralRivalTakesTheCertaintyAway) {
  Diagnosis diagnosis = TwoFindings();
  diagnosis.verdict = DiagnosisVerdict::kAmbiguous;
  diagnosis.findings[0].candidates.push_back({"pulley_eccentric", "x", 0.0, true});

  const std::string text = DiagnosisText(diagnosis, {});

  EXPECT_THAT(text, HasSubstr("Cannot tell it from: eccentric pulley of X."));
  EXPECT_THAT(FindingText(diagnosis.findings[0], diagnosis, "X"),
              Not(HasSubstr("nothing else fits")));
}

TEST(DiagnosisText, NoneSaysWhatWouldHaveShown) {
  const Diagnosis diagnosis{
      .gain = {.blocks = {.before_mm = 0.0013, .groups = 5}, .noise_floor_mm = 0.0012}};
  const TextNotes notes{
      .would_show = {{"cyclic_lead", "x", 0.002},
                     {"squareness", "C0Y", std::numeric_limits<double>::infinity()}}};

  const std::string text = DiagnosisText(diagnosis, notes);

  EXPECT_THAT(text, HasSubstr("Verdict: none."));
  EXPECT_THAT(text, HasSubstr("shown cyclic error of the X screw from 2 um."));
  EXPECT_THAT(text, HasSubstr("could not show squareness of X and Y (C0Y)"));
}

TEST(DiagnosisText, TellsRowsLeftOutAndChanges) {
  Diagnosis diagnosis = TwoFindings();
  diagnosis.outlier_rows = {17};
  const TextNotes notes{.changes = {{.name = "backlash.x",
                                     .unit = "mm",
                                     .before = 0.02,
                                     .before_sd = 0.001,
                                     .now = 0.05,
                                     .now_sd = 0.001,
                                     .sigmas = 21.2,
                                     .is_more_than_noise = true}},
                        .has_before = true};

  const std::string text = DiagnosisText(diagnosis, notes);

  EXPECT_THAT(text, HasSubstr("Row 17 left out"));
  EXPECT_THAT(text, HasSubstr("1 of 1 figures changed by more than noise"));
  EXPECT_THAT(text, HasSubstr("0.020 +- 0.001 mm -> 0.050 +- 0.001 mm"));
}

TEST(DiagnosisText, DoesNotCompareWhatIsNotTold) {
  const TextNotes notes{.changes = {{.name = "scale.z",
                                     .unit = "ppm",
                                     .now = 0,
                                     .now_sd = 23631,
                                     .now_is_determined = false}},
                        .has_before = true};

  const std::string text = DiagnosisText({}, notes);

  EXPECT_THAT(text,
              HasSubstr("not told by one of the two, so not compared: scale.z\n"));
  EXPECT_THAT(text, Not(HasSubstr("23631")));
}

// The three cases of a table: of use, of use between its ends, of no use.
TEST(DiagnosisText, DoesNotRecommendWhatMakesUnseenRowsWorse) {
  Diagnosis diagnosis = TwoFindings();
  diagnosis.findings = {{.cause = "pitch_map",
                         .axis = "x",
                         .share = 0.9,
                         .covariates = {"x"},
                         .map = FreeMap{.channel = "x", .covariates = {"x"}}}};
  HeldOut better{.before_mm = 0.0306, .after_mm = 0.0215, .rows = 20, .groups = 2};
  HeldOut worse{.before_mm = 0.0306, .after_mm = 0.0357, .rows = 20, .groups = 2};
  diagnosis.gain.positions = diagnosis.gain.ends = better;
  EXPECT_THAT(DiagnosisText(diagnosis, {}), Not(HasSubstr("worse")));

  diagnosis.gain.ends = worse;
  const std::string between = DiagnosisText(diagnosis, {});
  EXPECT_THAT(between,
              HasSubstr("beyond them it makes rows worse that it has not seen (31 um "
                        "rms without what was found, 36 with it)."));
  EXPECT_THAT(between, HasSubstr("What to do: Enter it"));

  diagnosis.gain.positions = worse;
  const std::string useless = DiagnosisText(diagnosis, {});
  EXPECT_THAT(useless, HasSubstr("Do not correct by it: between the positions"));
  EXPECT_THAT(useless, Not(HasSubstr("What to do: Enter it")));
}

TEST(WhatRowsMeasure, IsAnAxisOnlyWhereAllRowsLieAlongIt) {
  EXPECT_EQ(WhatRowsMeasure({.rows = {Along(1, 0), Along(-1, 0)}}), "X");
  EXPECT_EQ(WhatRowsMeasure({.rows = {Along(1, 0), Along(0, 1)}}), "the rows");
  EXPECT_EQ(WhatRowsMeasure({.rows = {Along(0.7, 0.7)}}), "the rows");
}

TEST(WithSd, GivesTheDigitsThatTheUncertaintyCarries) {
  EXPECT_EQ(WithSd(5.634, 0.21, "um"), "5.6 +- 0.2 um");
  EXPECT_EQ(WithSd(5.634, 0.097, "um"), "5.6 +- 0.1 um");
  EXPECT_EQ(WithSd(1234.4, 25, "ppm"), "1234 +- 25 ppm");
  EXPECT_EQ(WithSd(-0.0002, 0.005, "mm"), "0.000 +- 0.005 mm");  // No sign.
  EXPECT_EQ(WithSd(8, 0, "mm"), "8.00 mm");
  EXPECT_EQ(WithSd(0.5, std::numeric_limits<double>::quiet_NaN(), ""), "0.500");
}

TEST(WhatItDoes, NamesAxesOfGeometricErrors) {
  EXPECT_EQ(
      WhatItDoes(
          {.cause = "straightness", .axis = "EYX", .parameters = {{"bow_um", 12, 1}}}),
      "X does not run straight: it bows by 12 +- 1 um towards Y (EYX)");
  EXPECT_EQ(
      WhatItDoes(
          {.cause = "angular", .axis = "EBX", .parameters = {{"slope_urad", 40, 2}}}),
      "X turns about Y as it moves: 40 +- 2 urad over its travel (EBX)");
}

TEST(WhatItDoes, OfUnknownSaysInWhatItDepends) {
  EXPECT_EQ(WhatItDoes({.cause = "unknown",
                        .axis = "x",
                        .covariates = {"x", "dir_x"},
                        .peak_um = 21}),
            "Something makes the X axis err by up to 21 um that depends on position "
            "along X and the sense of approach of X; its shape fits no cause in the "
            "catalogue");
}

TEST(WhatItDoes, OfRowsWithoutTimesSpeaksOfTheirOrder) {
  Finding finding{.cause = "unknown", .axis = "x", .covariates = {"t"}, .peak_um = 21};
  EXPECT_THAT(WhatItDoes(finding), HasSubstr("depends on time;"));
  finding.is_by_order = true;
  EXPECT_THAT(WhatItDoes(finding), HasSubstr("depends on the order of the rows;"));
}

}  // namespace
}  // namespace caltwin
