#include "calibration/diagnosis/closed_loop.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::StrEq;

PlannedSession Planned() {
  const Plan plan{.campaigns = {DefaultCampaign("plate"), DefaultCampaign("iso230")}};
  return PlanSession(plan, ReadMachine("models/gantry_router/machine.yaml"), 1);
}

MeasuredSession ThreeRounds() {
  MeasuredSession session;
  for (const int round : {1, 2, 3}) {
    session = Continued(std::move(session), Planned(), round);
  }
  return session;
}

TEST(Continued, TimeRunsOnAndRowsAreNumberedThrough) {
  const auto rows = ThreeRounds().table.rows;

  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].row, rows[i - 1].row + 1);
    EXPECT_GE(rows[i].t_s, rows[i - 1].t_s);
  }
}

TEST(Continued, SetupsHomingsAndCampaignsAreTheRoundsOwn) {
  const std::size_t count = Planned().rows.size();
  const MeasuredSession session = ThreeRounds();

  std::set<std::string> of_round[3];
  for (std::size_t i = 0; i < session.table.rows.size(); ++i) {
    const Row& row = session.table.rows[i];
    of_round[i / count].insert({row.setup, "home " + row.home, row.campaign});
    EXPECT_TRUE(session.header.campaigns.contains(row.campaign)) << row.campaign;
  }
  for (const std::string& name : of_round[1]) {
    EXPECT_FALSE(of_round[0].contains(name) || of_round[2].contains(name)) << name;
  }
}

TEST(Continued, RowsWithoutTimesStayWithout) {
  MeasuredSession session{.table = {.rows = {Row{.row = 7, .campaign = "by hand"}}}};

  session = Continued(std::move(session), Planned(), 1);

  EXPECT_EQ(session.table.rows[1].row, 8);
  EXPECT_FALSE(Known(session.table.rows[1].t_s));
}

TEST(RoundText, SaysWhatWasMeasuredAndWhatIsLeft) {
  const LoopRound given{.rows = 49,
                        .verdict = DiagnosisVerdict::kAmbiguous,
                        .candidates = {"gantry_sag", "bed_cylinder.x"}};
  const LoopRound dense{.round = 2,
                        .campaign = "dense",
                        .options = {{"axis", "y"}},
                        .minutes = 6.2,
                        .rows = 170,
                        .verdict = DiagnosisVerdict::kNone};

  EXPECT_THAT(RoundText(given),
              StrEq("Round 0: the rows given, 49 rows in all: ambiguous (gantry_sag, "
                    "bed_cylinder.x)"));
  EXPECT_THAT(RoundText(dense),
              StrEq("Round 2: dense axis y, 6 min, 170 rows in all: none"));
}

}  // namespace
}  // namespace caltwin
