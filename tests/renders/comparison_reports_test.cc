// Reports of comparisons and of ISO 230-2 sheets say what their figures say, first.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renders/compare_report.h"
#include "renders/html.h"
#include "renders/iso230_report.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Contender Of(std::string name, int failures, double median_um, double p95_um) {
  return {.name = std::move(name),
          .machines = 50,
          .failures = failures,
          .error_um = {.median = median_um, .p95 = p95_um, .low = 1, .high = 20}};
}

// Who fails less often comes first, however small the rest of the other's errors is.
TEST(CompareReport, NamesWhoFailsLeastAndThenLeavesLeast) {
  const Document document = CompareDocument(
      {Of("eager", 5, 2, 4), Of("steady", 0, 8, 18), Of("rough", 0, 40, 90)},
      {.kind = "levelling"});

  EXPECT_EQ(document.verdict,
            "steady leaves least: 8 µm (median of 50 machines), 18 µm on 95 of 100; it "
            "never failed.");
  EXPECT_THAT(DocumentHtml(document),
              AllOf(HasSubstr("5 of 50 failed"), Not(HasSubstr("<script"))));
}

// A drawing is a file of its own too.
TEST(CompareReport, ItsDrawingIsADrawingAlone) {
  const Document document =
      CompareDocument({Of("steady", 0, 8, 18)}, {.kind = "levelling"});

  ASSERT_EQ(document.drawings.size(), 1);
  EXPECT_TRUE(document.drawings[0].svg.starts_with("<svg "));
  EXPECT_TRUE(document.drawings[0].svg.ends_with("</svg>\n"));
}

TEST(CompareReport, NobodyWinsWhereNobodyTellsAValue) {
  const Document document =
      CompareDocument({Of("blind", 50, 0, 0)}, {.kind = "backlash"});

  EXPECT_EQ(document.verdict, "No procedure told a value on these machines.");
  EXPECT_THAT(DocumentHtml(document), Not(HasSubstr("<svg")));
}

Iso230Sheet TwoPlaces() {
  Iso230Sheet sheet{.axis = Axis::kY, .campaign = "<laser>"};
  sheet.symbols = {.a = 0.0123, .r = 0.004, .b = 0.0051, .a_fwd = 0.008};
  sheet.positions = {
      {.target_mm = 10, .mean_fwd_mm = 0.001, .mean_bwd_mm = -0.004, .b_mm = 0.005},
      {.target_mm = 90, .mean_fwd_mm = 0.002, .s_fwd_mm = 0.0005}};
  return sheet;
}

TEST(Iso230Document, SaysAccuracyRepeatabilityAndReversal) {
  const std::string html =
      DocumentHtml(Iso230Document(TwoPlaces(), {.data = "x/<rows>.csv"}));

  EXPECT_THAT(html,
              AllOf(HasSubstr("Y positions within A = 12.3 µm over both directions; "
                              "repeatability R = 4 µm, reversal B = 5.1 µm."),
                    HasSubstr("&lt;rows&gt;.csv, axis Y"),
                    HasSubstr("Campaign &lt;laser&gt;."),
                    Not(testing::ContainsRegex("[ \"M>]nan"))));
}

TEST(Iso230Document, SaysWhatOneDirectionOrTooFewRunsDetermine) {
  Iso230Sheet sheet = TwoPlaces();
  sheet.symbols.a.reset();
  EXPECT_EQ(Iso230Document(sheet, {}).verdict,
            "Y positions within 8 µm in one direction (forward); the other was not "
            "measured.");
  sheet.symbols = {};
  EXPECT_THAT(Iso230Document(sheet, {}).verdict, HasSubstr("do not determine"));
}

TEST(Sentences, AreSetAsPeopleWriteThem) {
  EXPECT_EQ(SentenceHtml("5.6 +- 0.2 um, by um_names & <b>"),
            "5.6 ± 0.2 µm, by um_names &amp; &lt;b&gt;");
  EXPECT_EQ(SentenceHtml("umber 3 umbrellas"), "umber 3 umbrellas");
}

}  // namespace
}  // namespace caltwin
