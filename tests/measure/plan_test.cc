#include "sim/measure/plan.h"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

PlannedSession SessionOf(const std::string& campaigns, std::uint64_t seed = 1) {
  return PlanSession(
      ReadPlanText("campaigns:\n" + campaigns, "plan.yaml"), Gantry(), seed);
}

std::vector<std::string> FaultsOf(const std::string& text) {
  try {
    ReadPlanText(text, "plan.yaml");
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

TEST(Plan, KnowsADefaultForEveryOption) {
  const Plan plan = ReadPlanText("campaigns: [iso230, ring: {points: 8}]", "plan.yaml");

  EXPECT_EQ(plan.campaigns[0].options.Count("positions"), 21);
  EXPECT_EQ(plan.campaigns[0].options.axis("axis"), Axis::kX);
  EXPECT_EQ(plan.campaigns[1].options.Count("points"), 8);
  EXPECT_TRUE(plan.campaigns[1].options.is_written("points"));
  EXPECT_THAT(plan.campaigns[1].options.Numbers("spindle_deg"),
              ElementsAre(0, 90, 180, 270));
}

TEST(Plan, NamesCampaignsOfOneKindApart) {
  const Plan plan = ReadPlanText(
      "campaigns: [iso230, iso230: {axis: y}, iso230: {name: z_line}]", "plan.yaml");

  EXPECT_EQ(plan.campaigns[0].name, "iso230");
  EXPECT_EQ(plan.campaigns[1].name, "iso230_2");
  EXPECT_EQ(plan.campaigns[2].name, "z_line");
}

TEST(Plan, SaysWhatIsWrongAndWhatIsMeant) {
  EXPECT_THAT(FaultsOf("campaigns:\n  - iso320: {axis: x}\n"),
              ElementsAre("plan.yaml:2:5: campaigns[0] names no kind of campaign: "
                          "'iso320'\n  did you mean 'iso230'?"));
  EXPECT_THAT(FaultsOf("campaigns:\n  - ring: {point: 8}\n")[0],
              AllOf(HasSubstr("plan.yaml:2:12"), HasSubstr("did you mean 'points'?")));
  EXPECT_THAT(FaultsOf("campaigns: []\n")[0], HasSubstr("is empty"));
  EXPECT_THAT(FaultsOf("campaigns:\n  - iso230: {axis: w}\n")[0],
              AllOf(HasSubstr("w"), HasSubstr("x, y, z")));
  EXPECT_THAT(FaultsOf("campaigns: [ring: {name: a}, blocks: {name: a}]")[0],
              HasSubstr("the name 'a' is used twice"));
  EXPECT_THAT(FaultsOf("machine: gantry_router\n")[0], HasSubstr("campaigns"));
}

TEST(Plan, RefusesWhatDoesNotFitTheMachine) {
  try {
    SessionOf("  - ballbar: {radius_mm: 170}\n");
    FAIL() << "no fault";
  } catch (const InputError& error) {
    EXPECT_THAT(error.faults()[0],
                AllOf(HasSubstr("plan.yaml:2:5"),
                      HasSubstr("campaign 'ballbar'"),
                      HasSubstr("beyond its travel of 0 to 300 mm")));
  }
}

class EveryCampaign : public ::testing::TestWithParam<std::string_view> {};

TEST_P(EveryCampaign, IsDocumentedWithValidDefaults) {
  const CampaignKind& kind = *FindCampaignKind(GetParam());

  EXPECT_FALSE(kind.about.empty());
  EXPECT_FALSE(kind.shows.empty());
  for (const PlanOption& option : kind.options) {
    EXPECT_FALSE(option.doc.empty()) << option.name;
  }
  EXPECT_NO_THROW(DefaultCampaign(kind.id));  // Reads every default.
}

TEST_P(EveryCampaign, KnowsTheCircumstancesOfEachReading) {
  const PlannedSession session = SessionOf("  - " + std::string(GetParam()) + "\n");

  ASSERT_FALSE(session.rows.empty());
  double before_s = -1;
  for (const Row& row : session.rows) {
    EXPECT_GE(row.t_s, before_s);
    before_s = row.t_s;
    double n2 = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_TRUE(Known(row.cmd_mm[i]) && Known(row.dir[i]));
      EXPECT_GE(row.since_rev_mm[i], 0);
      n2 += row.n[i] * row.n[i];
      // A touch comes against the surface it finds.
      if (row.kind == RowKind::kTouch && std::abs(row.n[i]) > 1e-9) {
        EXPECT_EQ(row.dir[i], -std::copysign(1, row.n[i]));
      }
    }
    EXPECT_NEAR(n2, 1, 1e-12);
    EXPECT_TRUE(Known(row.temp_screw_c) && Known(row.temp_bed_c));
    EXPECT_FALSE(row.setup.empty());
    if (row.kind == RowKind::kTouch) {
      EXPECT_GT(row.feed_mm_s, 0);
      EXPECT_THAT(row.feature, HasSubstr("."));
    }
  }
}

TEST_P(EveryCampaign, IsExplainedByItsHeaderAndSurvivesItsFile) {
  PlannedSession session = SessionOf("  - " + std::string(GetParam()) + "\n");

  const RowTable table{.rows = session.rows};
  EXPECT_THAT(Unexplained(table, session.header), ::testing::IsEmpty());
  EXPECT_EQ(ParseRows(RowsText(table), "data.csv").rows.size(), session.rows.size());
  const DataHeader header =
      ParseDataHeader(DataHeaderText(session.header), "data.yaml");
  EXPECT_THAT(header.remarks, ::testing::IsEmpty());
  EXPECT_EQ(header.campaigns.begin()->second.plan, GetParam());
}

TEST_P(EveryCampaign, TakesMinutesNotDays) {
  const double minutes = Minutes(DefaultCampaign(GetParam()), Gantry());

  EXPECT_GT(minutes, 1);
  EXPECT_LT(minutes, 300);
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryCampaign,
                         ::testing::Values("iso230",
                                           "dense",
                                           "abbe",
                                           "straightedge",
                                           "square",
                                           "blocks",
                                           "plate",
                                           "plate_turned_90",
                                           "ring",
                                           "ballbar",
                                           "alternating",
                                           "rehoming",
                                           "drift"),
                         [](const auto& id) { return std::string(id.param); });

TEST(PlannedRows, TheSameSeedGivesTheSameRowsAndMoreCampaignsTheSameBeginning) {
  const std::string first = "  - blocks: {points: 2}\n";
  const auto once = SessionOf(first, 5).rows;
  const auto longer = SessionOf(first + "  - ring\n", 5).rows;
  const auto other = SessionOf(first, 6).rows;

  ASSERT_GT(longer.size(), once.size());
  EXPECT_EQ(RowsText({.rows = once}),
            RowsText({.rows = {longer.begin(),
                               longer.begin() + static_cast<long>(once.size())}}));
  EXPECT_NE(RowsText({.rows = once}), RowsText({.rows = other}));
}

TEST(PlannedRows, RandomTargetsHideNoPeriod) {
  std::set<long> phases;
  for (const Row& row : SessionOf("  - iso230: {runs: 1}\n").rows) {
    phases.insert(std::lround(std::fmod(row.cmd_mm[0], 4.0) * 2));
  }
  std::set<long> regular;
  for (const Row& row :
       SessionOf("  - iso230: {runs: 1, regular: true, positions: 72}\n").rows) {
    regular.insert(std::lround(std::fmod(row.cmd_mm[0], 4.0) * 2));
  }

  EXPECT_GE(phases.size(), 6U);
  EXPECT_EQ(regular.size(), 1U);  // 284 mm in 71 steps: always the same phase.
}

TEST(PlannedRows, ALineIsReadFromBothSensesWithTheTravelSinceTheReversal) {
  const auto rows =
      SessionOf("  - iso230: {positions: 2, runs: 1, regular: true}\n").rows;

  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1].cmd_mm[0], 292);
  EXPECT_EQ(rows[1].dir[0], 1);
  EXPECT_EQ(rows[2].cmd_mm[0], 292);
  EXPECT_EQ(rows[2].dir[0], -1);
  EXPECT_NEAR(rows[2].since_rev_mm[0], 4, 1e-9);  // The overrun.
  EXPECT_NEAR(rows[3].since_rev_mm[0], 288, 1e-9);
}

TEST(PlannedRows, ADenseRunReadsTheReversalItself) {
  const auto rows = SessionOf("  - dense\n").rows;

  const auto turn =
      std::ranges::find_if(rows, [](const Row& row) { return row.dir[0] < 0; });
  ASSERT_NE(turn, rows.end());
  EXPECT_LT(turn->since_rev_mm[0], 4.0 / 24 * 1.02);
}

TEST(PlannedRows, ATurnedPlateIsTouchedWhereTheOtherWas) {
  auto places = [](const std::string& kind) {
    std::set<std::pair<double, double>> found;
    for (const Row& row : SessionOf("  - " + kind + "\n").rows) {
      EXPECT_EQ(row.artefact_turn_deg, kind == "plate" ? 0 : 90);
      found.emplace(row.cmd_mm[0], row.cmd_mm[1]);
    }
    return found;
  };

  EXPECT_EQ(places("plate"), places("plate_turned_90"));
}

TEST(PlannedRows, ADriftRunWarmsUpAndCoolsDownWithBedAndFrameApart) {
  const auto rows = SessionOf("  - drift\n").rows;

  const auto at = [&](double t_s) {
    return *std::ranges::lower_bound(rows, t_s, {}, &Row::t_s);
  };
  // Spindle on 0 .. 7200 s, bed 2880 .. 9360 s.
  EXPECT_GT(at(2800).temp_frame_c, at(0).temp_frame_c + 1);
  EXPECT_LT(at(2800).temp_bed_c, at(0).temp_bed_c + 0.3);
  EXPECT_LT(at(9300).temp_frame_c, at(7200).temp_frame_c - 1);
  EXPECT_GT(at(9300).temp_bed_c, at(7200).temp_bed_c - 0.5);
  EXPECT_LT(rows.back().temp_bed_c, at(9300).temp_bed_c - 4);
}

TEST(PlannedRows, OtherwiseTemperaturesStaySteady) {
  const auto rows = SessionOf("  - plate\n  - ring\n").rows;
  const auto [low, high] = std::ranges::minmax(rows, {}, &Row::temp_screw_c);

  EXPECT_LE(high.temp_screw_c - low.temp_screw_c, 0.3);
}

TEST(PlannedRows, EachHomingIsASessionOfItsOwn) {
  std::set<std::string> homes;
  for (const Row& row : SessionOf("  - rehoming: {homings: 5}\n").rows) {
    homes.insert(row.home);
  }

  EXPECT_EQ(homes.size(), 5U);
}

TEST(PlannedRows, AWrittenUncertaintyOfAnArtefactReachesTheHeader) {
  const Plan plan = ReadPlanText(
      "artefacts: {ring: {type: ring, u_um: 0.1}}\ncampaigns: [ring]", "plan.yaml");

  const auto session = PlanSession(plan, Gantry(), 1);

  EXPECT_EQ(session.header.artefacts.at("ring").u_um, 0.1);
  EXPECT_THAT(session.header.artefacts.at("ring").sizes_mm, ElementsAre(50));
}

}  // namespace
}  // namespace caltwin
