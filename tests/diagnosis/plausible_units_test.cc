// Columns in other units than their names say, alone or in part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "tests/diagnosis/doubted.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(PlausibleUnits, TemperaturesInOtherUnits) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->temp_frame_c = 28; }), IsEmpty());
  EXPECT_THAT(KindsAfter([](Row* row) { row->temp_frame_c = 301; }),
              ElementsAre("temperature_unit!"));
  EXPECT_THAT(KindsAfter([](Row* row) { row->temp_ambient_c = 68; }),
              ElementsAre("temperature_unit"));
  EXPECT_THAT(KindsAfter([](Row* row) { row->temp_bed_c = 105; }), IsEmpty());
}

TEST(PlausibleUnits, StatedUncertaintiesInOtherUnits) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->sigma_mm = 0.002; }), IsEmpty());
  EXPECT_THAT(KindsAfter([](Row* row) { row->sigma_mm = 2; }),
              ElementsAre("sigma_unit"));
  DataHeader header;
  header.instruments["laser"] = {.kind = "laser", .sigma_um = 2000};
  header.campaigns["iso230_x"] = {.instrument = "laser"};
  EXPECT_THAT(KindsOf(X(), header), ElementsAre("sigma_unit"));
}

// What is said of a stated uncertainty so many times the scatter of X's repeats.
std::string HintOfSigma(double times) {
  constexpr double kScatter_mm = 0.003165;
  RowTable table = X();
  for (Row& row : table.rows) row.sigma_mm = times * kScatter_mm;
  const auto doubts = Doubts(table, {});
  return doubts.size() == 1 && doubts[0].kind == "sigma_unit" ? doubts[0].hint : "";
}

TEST(PlausibleUnits, AColumnInTwoUnitsOfTemperature) {
  const auto warm = [](Row* row) {
    row->temp_screw_c = row->row < 40 ? 24.6 : 24.9;
  };
  EXPECT_THAT(KindsAfter(warm), IsEmpty());
  EXPECT_THAT(KindsAfter([&](Row* row) {
                warm(row);
                if (row->row >= 40) row->temp_screw_c = 1.8 * row->temp_screw_c + 32;
              }),
              ElementsAre("temperature_unit!"));
}

TEST(PlausibleUnits, PositionsThatInInchesWouldFillTheTravelAreTold) {
  const Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  const auto kinds_of = [&](double times) {
    RowTable table = X();
    for (Row& row : table.rows) {
      row.cmd_mm[0] = times * (150 + 6.9317 * row.cmd_mm[0]);
    }
    return KindsOf(table, {}, &machine);
  };
  EXPECT_THAT(kinds_of(1), IsEmpty());
  EXPECT_THAT(kinds_of(1 / 25.4), Contains("position_unit"));
}

TEST(PlausibleUnits, InchesShowBesideAStatedUncertainty) {
  EXPECT_THAT(HintOfSigma(25.4), HasSubstr("is value_mm in inches"));
  EXPECT_THAT(HintOfSigma(1 / 25.4), HasSubstr("is the uncertainty in inches"));
  EXPECT_THAT(HintOfSigma(1 / 39.37), HasSubstr("is value_mm in thousandths"));
  EXPECT_EQ(HintOfSigma(12), "");
  EXPECT_EQ(HintOfSigma(1 / 12.0), "");
}

}  // namespace
}  // namespace caltwin
