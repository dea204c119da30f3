#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/measure/import_bench.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StrEq;

constexpr double kWritten_mm = 1e-9;  // Of a position written to 1e-9 mm.

/// Rows of one axis as the European Spallation Source's program writes them: positions
/// of the reference system by position and run, first all forward, then all backward.
std::string EcmcText(const RowTable& table) {
  std::string targets, forward, backward;
  for (const Row& row : table.rows) {
    const int position = static_cast<int>(std::lround((row.cmd_mm[0] + 20) / 5)) + 1;
    if (row.rep == 1 && row.dir[0] > 0) {
      targets += fmt::format("TGT_DATA[{}]={}\n", position, row.cmd_mm[0]);
    }
    (row.dir[0] > 0 ? forward : backward) += fmt::format("REF_DATA_{}[{},{}]={:.9f}\n",
                                                         row.dir[0] > 0 ? "FWD" : "BWD",
                                                         position,
                                                         *row.rep,
                                                         row.cmd_mm[0] + row.value_mm);
  }
  return "TEST_DATA=# derived from x.log\n#\nTGT_SET_PV=TARGET_DU:X-PosCmd\nUNIT=mm\n" +
         targets + forward + backward + "  \n";
}

TEST(ImportIso230, EcmcDataGiveTheRowsOfTheRealAxis) {
  const RowTable real =
      ParseRows(TestData("iso230/ess_target_x_2022-04.csv"), "real.csv");
  const RowTable read = RowsOf("iso230-dat", EcmcText(real));

  ASSERT_EQ(read.rows.size(), real.rows.size());
  for (std::size_t i = 0; i < real.rows.size(); ++i) {
    EXPECT_EQ(read.rows[i].campaign, "iso230_x");
    EXPECT_EQ(read.rows[i].rep, real.rows[i].rep);
    EXPECT_EQ(read.rows[i].dir[0], real.rows[i].dir[0]);
    EXPECT_EQ(read.rows[i].cmd_mm[0], real.rows[i].cmd_mm[0]);
    EXPECT_NEAR(read.rows[i].value_mm, real.rows[i].value_mm, kWritten_mm);
  }
}

TEST(ImportIso230, MeasuredRowsAreTakenAsTheyAre) {
  const std::string text = TestData("iso230/psi_mcu1025_2021-11-10.csv");
  const Imported imported = ImportText("iso230-dat", text, "psi.csv", {});

  EXPECT_THAT(imported.recognised,
              ::testing::ElementsAre("50 measured rows already, taken as they are"));
  EXPECT_EQ(imported.table.rows[0].value_mm, 0.100347);
}

constexpr const char* kSmallEcmc =
    "UNIT=um\nTGT_SET_PV=IOC:Axis1-PosSet\nTGT_DATA[1]=0\nTGT_DATA[2]=5000\n"
    "REF_DATA_FWD[1,1]=1\nREF_DATA_FWD[2,1]=5002\nREF_DATA_BWD[2,1]=5003\n";

TEST(ImportIso230, EcmcUnitAndUnknownAxis) {
  const Imported imported = ImportText("iso230-dat", kSmallEcmc, "f", {});

  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_NEAR(imported.table.rows[1].value_mm, 0.002, kWritten_mm);
  EXPECT_EQ(imported.table.rows[1].cmd_mm[0], 5);
  EXPECT_EQ(imported.table.rows[2].dir[0], -1);
  EXPECT_THAT(imported.assumed.back(), HasSubstr("the axis is x"));
  const auto on_z = ImportText("iso230-dat", kSmallEcmc, "f", {.axis = "z"});
  EXPECT_EQ(on_z.table.rows[1].cmd_mm[2], 5);
  EXPECT_THAT(on_z.table.rows[1].n, ::testing::ElementsAre(0, 0, 1));
}

TEST(ImportIso230, EcmcFaultsAreNamedWithTheirPlace) {
  EXPECT_THAT(ImportFault("iso230-dat", "TGT_DATA[1]=0\nREF_DATA_FWD[2,1]=1\n"),
              StrEq("f:2:19: position 2 has no TGT_DATA"));
  EXPECT_THAT(ImportFault("iso230-dat", "TGT_DATA[1]=0\nREF_DATA_FWD[1,1]=nan\n"),
              StrEq("f:2:19: a position = 'nan' is not a finite number"));
  EXPECT_THAT(
      ImportFault("iso230-dat", "TGT_DATA[1]=0\nREF_DATA_FWD[1]=1\n"),
      HasSubstr("f:2:17: 'REF_DATA_FWD[1]' is no index of this format\n  it is"));
  EXPECT_THAT(ImportFault("iso230-dat", "TGT_DATA[1]=0\n"),
              HasSubstr("but no REF_DATA_FWD"));
  EXPECT_THAT(ImportFault("iso230-dat", "TGT_DATA[1]=0\nTGT_DATA[1]=0\n"),
              StrEq("f:2:13: TGT_DATA[1] stands here twice"));
  EXPECT_THAT(ImportFault("iso230-dat", std::string(kSmallEcmc), {.unit = "furlong"}),
              HasSubstr("the unit 'furlong' is not known here\n  it may be: mm, um"));
}

constexpr const char* kRtl =
    "HEADER::\nFile type: 1\nTARGET DATA::\nTarget-count: 3\nTargets :\n"
    "0.0 100.0\n200.0\nFlags: 0\nUSER-TEXT::\nAxis: Y\nRUNS::\nRun-count: 2\n"
    "DEVIATIONS::\nRun Target Data:\n1 1 0.0\n1 2 1.5\n1 3 2.5\n2 3 3.0\n2 2 2.0\n"
    "2 1 0.5\nEQUIPMENT::\n";

TEST(ImportIso230, RenishawSensesComeFromTheOrderOfTargets) {
  const RowTable table = RowsOf("iso230-dat", kRtl, {.unit = "um"});

  ASSERT_THAT(table.rows, SizeIs(6));
  EXPECT_EQ(table.rows[1].cmd_mm[1], 100);
  EXPECT_DOUBLE_EQ(table.rows[1].value_mm, 0.0015);
  EXPECT_EQ(table.rows[2].dir[1], 1);
  EXPECT_EQ(table.rows[3].dir[1], -1);
  EXPECT_EQ(table.rows[3].rep, 2);
}

TEST(ImportIso230, RenishawDoesNotSayItsUnitSoItIsAsked) {
  EXPECT_THAT(
      ImportFault("iso230-dat", kRtl),
      StrEq("f:15:1: this format does not say the unit of its deviations\n  say "
            "it: --unit um or --unit mm (what the laser's display showed)"));
}

TEST(ImportIso230, ASheetWithDecimalCommasInMicrometres) {
  const RowTable table = RowsOf("csv",
                                "ziel;abw [µm]\n0;1,5\n10;-2,5\n",
                                {.map = {"cmd_x_mm=ziel[mm],value_mm=2"}});
  EXPECT_DOUBLE_EQ(table.rows[1].value_mm, -0.0025);

  const RowTable sheet = RowsOf("iso230-dat",
                                "target,fwd1_um,bwd1_um,fwd2_um,bwd2_um\n"
                                "0,1,2,1.5,2.5\n10,3,4,3.5,4.5\n");
  ASSERT_THAT(sheet.rows, SizeIs(8));
  EXPECT_DOUBLE_EQ(sheet.rows[2].value_mm, 0.004);  // Backward begins at the far end.
  EXPECT_EQ(sheet.rows[2].dir[0], -1);
  EXPECT_EQ(sheet.rows[7].rep, 2);
}

TEST(ImportIso230, ASheetMustSaySensesAndUnit) {
  EXPECT_THAT(ImportFault("iso230-dat", "target,run1,run2\n0,1,2\n"),
              HasSubstr("f:1:8: the heading 'run1' does not say in which sense"));
  EXPECT_THAT(ImportFault("iso230-dat", "target,fwd1\n0,1\n"),
              HasSubstr("f:1:8: nothing says the unit of the deviations"));
  EXPECT_THAT(ImportFault("iso230-dat", "hello\n"),
              HasSubstr("f:1:1: this is no positioning test in a form that is known"));
}

}  // namespace
}  // namespace caltwin
