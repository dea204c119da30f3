// What two instruments on one axis say against each other, against closed forms.

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

struct Reading {
  double scale = 0, gap_mm = 0, sigma_mm = 0.001;
};

// Ten places from both sides, twice, on an axis that itself errs by 0.2 mm/m.
std::vector<Row> Measured(const std::string& campaign,
                          const Reading& reading,
                          std::uint64_t seed) {
  Rng rng(seed, 0, "instruments");
  std::vector<Row> rows;
  for (int round = 0; round < 2; ++round) {
    for (const double sense : {1.0, -1.0}) {
      for (int i = 0; i < 10; ++i) {
        Row row{.campaign = campaign};
        row.cmd_mm[0] = 30.0 * i;
        row.dir[0] = sense;
        row.n[0] = 1;
        row.value_mm = (2e-4 + reading.scale) * row.cmd_mm[0] -
                       sense * (0.02 + reading.gap_mm) / 2 +
                       reading.sigma_mm * rng.Normal();
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

Facts Of(const Reading& laser,
         const Reading& dial,
         double u_laser_um,
         double u_dial_um) {
  DataHeader header;
  header.instruments["laser"] = {.kind = "laser", .u_um = u_laser_um};
  header.instruments["dial"] = {.kind = "dial", .u_um = u_dial_um};
  header.campaigns["first"].instrument = "laser";
  header.campaigns["second"].instrument = "dial";
  RowTable table{.rows = Measured("first", laser, 1)};
  for (Row& row : Measured("second", dial, 2)) table.rows.push_back(std::move(row));
  std::int64_t number = 0;
  for (Row& row : table.rows) row.row = ++number;
  return FactsOf(table, header, {});
}

TEST(FactsOfInstruments, ADialThatReadsALongerWayErrsWhereTheLaserIsCertified) {
  const Facts facts = Of({}, {.scale = 3e-4}, 1, 10);
  const Fact* fact = facts.Find("contradiction");

  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "instruments");
  EXPECT_EQ(fact->axis, "x");
  EXPECT_NEAR(FigureOf(*fact, "apart_ppm"), 300, 10);
  EXPECT_NEAR(FigureOf(*fact, "apart_um"), 81, 3);
  EXPECT_TRUE(fact->is_answer);
  EXPECT_THAT(fact->sentence,
              HasSubstr("'dial' reads a longer way than 'laser' along X"));
  EXPECT_THAT(fact->sentence, HasSubstr("'dial' errs"));
  EXPECT_THAT(facts.not_determined, Not(Contains("cause")));
}

TEST(FactsOfInstruments, WithoutCertificatesNobodyKnowsWhich) {
  const Facts facts = Of({.scale = 3e-4}, {}, 0, 0);
  const Fact* fact = facts.Find("contradiction");

  ASSERT_NE(fact, nullptr);
  EXPECT_THAT(fact->sentence,
              HasSubstr("'laser' reads a longer way than 'dial' along X"));
  EXPECT_THAT(fact->sentence, HasSubstr("cannot say which"));
  EXPECT_THAT(facts.not_determined, Contains("cause"));
  ASSERT_FALSE(facts.next.empty());
  EXPECT_EQ(facts.next.front().instrument, "block");
}

TEST(FactsOfInstruments, ADialWithAGapOfItsOwnReadsAWiderReversal) {
  const Facts facts = Of({}, {.gap_mm = 0.015}, 0, 0);
  const Fact* fact = facts.Find("contradiction");

  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "gap_um"), 15, 2);
  EXPECT_THAT(fact->sentence, HasSubstr("'dial' reads a wider gap than 'laser'"));
}

TEST(FactsOfInstruments, WithinWhatIsStatedIsNoAnswer) {
  const Facts facts = Of({}, {.scale = 3e-4}, 1, 100);
  const Fact* fact = facts.Find("contradiction");

  ASSERT_NE(fact, nullptr);
  EXPECT_FALSE(fact->is_answer);
  EXPECT_THAT(fact->sentence, HasSubstr("within the 100 um"));
}

TEST(FactsOfInstruments, ThatAgreeSaySo) {
  const Facts facts = Of({}, {}, 0, 0);

  EXPECT_EQ(facts.Find("contradiction"), nullptr);
  const Fact* fact = facts.Find("agreement");
  ASSERT_NE(fact, nullptr);
  EXPECT_THAT(fact->sentence, HasSubstr("agree about X"));
  EXPECT_NEAR(FigureOf(*fact, "apart_um"), 0, 2);
}

}  // namespace
}  // namespace caltwin
