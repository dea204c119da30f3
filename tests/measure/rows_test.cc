#include "sim/measure/rows.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StrEq;

std::string MessagesOf(const std::string& text) {
  try {
    ParseRows(text, "d.csv");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Faults in one line of values under a fixed header.
std::string MessagesOfLine(const std::string& line) {
  return MessagesOf("campaign,cmd_x_mm,dir_x,value_mm\n" + line + "\n");
}

TEST(Rows, TheSmallestFileIsRead) {
  const RowTable table =
      ParseRows("campaign,cmd_x_mm,value_mm\na,10,-0.005\n", "d.csv");

  ASSERT_THAT(table.rows, SizeIs(1));
  const Row& row = table.rows[0];
  EXPECT_EQ(row.row, 1);
  EXPECT_EQ(row.kind, RowKind::kPosition);
  EXPECT_EQ(row.cmd_mm[0], 10);
  EXPECT_EQ(row.value_mm, -0.005);
  EXPECT_THAT(row.n, ElementsAre(1, 0, 0));
  EXPECT_FALSE(Known(row.dir[0]));
  EXPECT_FALSE(Known(row.t_s));
  EXPECT_EQ(row.place.line, 2);
}

TEST(Rows, EveryColumnGoesToItsPlace) {
  const std::string text =
      "row,kind,campaign,setup,home,rep,settings,t_s,temp_screw_c,temp_frame_c,"
      "temp_bed_c,temp_chamber_c,temp_ambient_c,cmd_x_mm,cmd_y_mm,cmd_z_mm,motor_a_mm,"
      "motor_b_mm,motor_c_mm,dir_x,dir_y,dir_z,dir_a,dir_b,dir_c,since_rev_x_mm,"
      "since_rev_y_mm,since_rev_z_mm,feed_mm_s,load_n,nx,ny,nz,feature,"
      "artefact_turn_deg,probe_angle_deg,probe_off_x_mm,probe_off_y_mm,probe_off_z_mm,"
      "sigma_mm,flag,value_mm\n"
      "17,touch,c,s,h,2,id,1,21,22,23,24,25,31,32,33,41,42,43,1,-1,0,-1,0,1,51,52,53,6,"
      "-7,0,-1,0,block.left,90,180,61,62,63,0.001,odd,0.02\n";
  const Row row = ParseRows(text, "d.csv").rows.at(0);

  EXPECT_EQ(row.row, 17);
  EXPECT_EQ(row.kind, RowKind::kTouch);
  EXPECT_EQ(row.campaign + row.setup + row.home + row.settings, "cshid");
  EXPECT_EQ(row.rep, 2);
  EXPECT_EQ(row.t_s, 1);
  EXPECT_EQ(row.temp_screw_c, 21);
  EXPECT_EQ(row.temp_frame_c, 22);
  EXPECT_EQ(row.temp_bed_c, 23);
  EXPECT_EQ(row.temp_chamber_c, 24);
  EXPECT_EQ(row.temp_ambient_c, 25);
  EXPECT_THAT(row.cmd_mm, ElementsAre(31, 32, 33));
  EXPECT_THAT(row.motor_mm, ElementsAre(41, 42, 43));
  EXPECT_THAT(row.dir, ElementsAre(1, -1, 0));
  EXPECT_THAT(row.motor_dir, ElementsAre(-1, 0, 1));
  EXPECT_THAT(row.since_rev_mm, ElementsAre(51, 52, 53));
  EXPECT_EQ(row.feed_mm_s, 6);
  EXPECT_EQ(row.load_n, -7);
  EXPECT_THAT(row.n, ElementsAre(0, -1, 0));
  EXPECT_EQ(row.feature, "block.left");
  EXPECT_EQ(row.artefact_turn_deg, 90);
  EXPECT_EQ(row.probe_angle_deg, 180);
  EXPECT_THAT(row.probe_off_mm, ElementsAre(61, 62, 63));
  EXPECT_EQ(row.sigma_mm, 0.001);
  EXPECT_EQ(row.flag, "odd");
  EXPECT_EQ(row.value_mm, 0.02);
  EXPECT_EQ(RowsText(ParseRows(text, "d.csv")),
            RowsText(ParseRows(RowsText(ParseRows(text, "d.csv")), "d.csv")));
}

TEST(Rows, WhatWasWrittenIsReadBackToTheLastBit) {
  RowTable table{.extra_columns = {"my note", "#2"},
                 .comments = {"made by a test", ""}};
  for (int i = 0; i < 20; ++i) {
    Row row{
        .row = i + 1, .campaign = "#1, \"odd\"", .flag = i == 3 ? " two\nlines" : ""};
    row.cmd_mm = {i / 3.0, kUnknown, std::ldexp(1.0, -i)};
    row.n = {0, 0, 1};
    row.value_mm = std::sin(i) * 1e-3;
    row.t_s = i % 2 == 0 ? kUnknown : -0.0;
    row.extra = {"x", ""};
    table.rows.push_back(row);
  }

  const std::string text = RowsText(table);
  const RowTable back = ParseRows(text, "d.csv");

  ASSERT_THAT(back.rows, SizeIs(20));
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(back.rows[i].cmd_mm[0], table.rows[i].cmd_mm[0]);
    EXPECT_EQ(back.rows[i].cmd_mm[2], table.rows[i].cmd_mm[2]);
    EXPECT_FALSE(Known(back.rows[i].cmd_mm[1]));
    EXPECT_EQ(back.rows[i].value_mm, table.rows[i].value_mm);
    EXPECT_EQ(back.rows[i].campaign, table.rows[i].campaign);
    EXPECT_EQ(back.rows[i].flag, table.rows[i].flag);
    EXPECT_EQ(back.rows[i].extra, table.rows[i].extra);
    EXPECT_EQ(Known(back.rows[i].t_s), i % 2 == 1);
  }
  EXPECT_TRUE(std::signbit(back.rows[1].t_s));
  EXPECT_EQ(back.extra_columns, table.extra_columns);
  EXPECT_EQ(back.comments, table.comments);
  EXPECT_EQ(RowsText(back), text);
}

TEST(Rows, ReadTheSameFromAFile) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "caltwin_rows.csv";
  const RowTable table = ParseRows("campaign,cmd_x_mm,value_mm\na,10,1\n", "d.csv");

  WriteRows(file, table);

  EXPECT_EQ(RowsText(ReadRows(file)), RowsText(table));
  std::filesystem::remove(file);
}

TEST(Rows, WindowsFilesWithQuotesAndCommentsAreRead) {
  const RowTable table = ParseRows(
      "\xEF\xBB\xBF# laser\r\n\"campaign\",cmd_x_mm,value_mm,flag\r\n"
      "a,10,0.1,\"first, odd\"\r\n\r\n# later\r\na,20,0.2,\r\n",
      "d.csv");

  EXPECT_THAT(table.rows, SizeIs(2));
  EXPECT_EQ(table.rows[0].flag, "first, odd");
  EXPECT_THAT(table.comments, ElementsAre("laser", "later"));
}

TEST(Rows, UnknownColumnsAreKeptAndReported) {
  const RowTable table =
      ParseRows("campaign,cmd_x_mm,value_mm,humidity,dirx\na,1,2,45 %,+1\n", "d.csv");

  EXPECT_THAT(table.extra_columns, ElementsAre("humidity", "dirx"));
  EXPECT_THAT(table.rows[0].extra, ElementsAre("45 %", "+1"));
  EXPECT_THAT(table.remarks,
              ElementsAre("d.csv:1:28: the column 'humidity' is not known and not used",
                          "d.csv:1:37: the column 'dirx' is not known and not used; "
                          "did you mean 'dir_x'?"));
}

TEST(Rows, MissingColumnsAreNamedTogether) {
  EXPECT_THAT(MessagesOf("campain,dir_x\na,1\n"),
              StrEq("d.csv:1:1: the column 'campaign' is missing\n"
                    "  is 'campain' meant for it?\n"
                    "d.csv:1:1: the column 'value_mm' is missing\n"
                    "d.csv:1:1: the commanded pose is missing\n"
                    "  at least one column of cmd_x_mm, cmd_y_mm, cmd_z_mm"));
}

TEST(Rows, AColumnTwiceOrWithoutANameIsAFault) {
  EXPECT_THAT(MessagesOf("campaign,cmd_x_mm,value_mm,dir_x,dir_x,\n"),
              StrEq("d.csv:1:34: the column 'dir_x' stands twice\n"
                    "d.csv:1:40: a column without a name"));
}

TEST(Rows, NumbersAreFiniteAndHaveADot) {
  EXPECT_THAT(MessagesOfLine("a,nan,1,inf"),
              StrEq("d.csv:2:3: cmd_x_mm = 'nan' is not a finite number\n"
                    "  an unknown value is an empty field\n"
                    "d.csv:2:9: value_mm = 'inf' is not a finite number\n"
                    "  an unknown value is an empty field\n"
                    "d.csv:2:1: the commanded pose is empty\n"
                    "  at least one of cmd_x_mm, cmd_y_mm, cmd_z_mm"));
  EXPECT_THAT(MessagesOfLine("a,10,1,\"0,5\""),
              StrEq("d.csv:2:8: value_mm = '0,5' is not a number\n"
                    "  the decimal mark is a dot"));
  EXPECT_THAT(
      MessagesOfLine("a,10,1,0,5"),
      StrEq("d.csv:2:8: 5 fields, where the header names 4 columns\n"
            "  the decimal mark is a dot; a text with a comma stands in quotes"));
  EXPECT_THAT(MessagesOfLine("a,10,1"),
              StrEq("d.csv:2:6: 3 fields, where the header names 4 columns\n"
                    "  an unknown value is an empty field between its commas"));
}

// As scripts do; what states none has none.
TEST(Rows, RowsAndRepetitionsCountFromAnyNumber) {
  const std::string heading = "row,campaign,rep,cmd_x_mm,value_mm\n";
  const RowTable counted =
      ParseRows(heading + "0,a,0,1,0\n1,a,-2,1,0\n2,a,,1,0\n", "d");
  EXPECT_EQ(counted.rows[0].rep, 0);
  EXPECT_EQ(counted.rows[1].rep, -2);
  EXPECT_FALSE(counted.rows[2].rep);
  EXPECT_THAT(RowsText(counted), HasSubstr("\n0,position,a,0,"));
  const RowTable table =
      ParseRows("row,campaign,cmd_x_mm,value_mm\n0,a,1,0\n4,a,2,0\n", "d");
  EXPECT_EQ(table.rows[0].row, 0);
  EXPECT_THAT(RowsText(table), HasSubstr("\n4,position,a,"));
  EXPECT_THAT(MessagesOf("row,campaign,cmd_x_mm,value_mm\n0,a,1,0\n0,a,2,0\n"),
              HasSubstr("row = 0 stands in line 2 already"));
  EXPECT_THAT(MessagesOf("row,campaign,cmd_x_mm,value_mm\n,a,1,0\n"),
              HasSubstr("row is empty"));
}

TEST(Rows, TheSenseIsMinusOneZeroOrOne) {
  EXPECT_THAT(MessagesOfLine("a,1,+1,0"), IsEmpty());
  EXPECT_THAT(MessagesOfLine("a,1,-1,0"), IsEmpty());
  EXPECT_THAT(MessagesOfLine("a,1,0,0"), IsEmpty());
  EXPECT_THAT(MessagesOfLine("a,1,,0"), IsEmpty());
  const std::string hint =
      "\n  the sense of the last approach: 1, -1, or 0 for an axis that did not move "
      "in "
      "it; empty where it is unknown";
  EXPECT_EQ(MessagesOfLine("a,1,0.5,0"),
            "d.csv:2:5: dir_x = '0.5' is not -1, 0 or 1" + hint);
  EXPECT_EQ(MessagesOfLine("a,1,2,0"),
            "d.csv:2:5: dir_x = '2' is outside -1 .. 1" + hint);
  EXPECT_EQ(MessagesOfLine("a,1,fwd,0"),
            "d.csv:2:5: dir_x = 'fwd' is not a number" + hint);
}

TEST(Rows, CampaignPoseAndValueAreNeverEmpty) {
  EXPECT_THAT(MessagesOfLine(",,1,"),
              StrEq("d.csv:2:5: value_mm is empty\n"
                    "  a row without a reading is left out of the file\n"
                    "d.csv:2:1: campaign is empty\n"
                    "  rows of one campaign share a name\n"
                    "d.csv:2:1: the commanded pose is empty\n"
                    "  at least one of cmd_x_mm, cmd_y_mm, cmd_z_mm"));
}

TEST(Rows, TheNormalIsAUnitVector) {
  const std::string header = "campaign,cmd_x_mm,cmd_y_mm,nx,ny,value_mm\n";

  EXPECT_THAT(MessagesOf(header + "a,1,2,0.6,0.7,0\n"),
              StrEq("d.csv:2:1: (nx, ny, nz) has the length 0.922\n"
                    "  it is a unit vector: its length is 1"));
  EXPECT_THAT(MessagesOf(header + "a,1,2,,,0\n"),
              StrEq("d.csv:2:1: nx, ny, nz are missing\n"
                    "  with more than one commanded axis a row says along which unit "
                    "vector its value is measured"));
  const Row rounded = ParseRows(header + "a,1,2,0.707,0.707,0\n", "d.csv").rows.at(0);
  EXPECT_DOUBLE_EQ(std::hypot(rounded.n[0], rounded.n[1]), 1);
  EXPECT_EQ(rounded.n[2], 0);
}

// The outward normal of what is touched faces the probe.
TEST(Rows, ATouchWithoutANormalIsMeasuredAgainstItsSense) {
  const RowTable table = ParseRows(
      "kind,campaign,cmd_x_mm,dir_x,value_mm\n"
      "touch,a,1,1,0\ntouch,a,1,-1,0\ntouch,a,1,,0\nposition,a,1,1,0\nposition,a,1,-1,"
      "0\n",
      "d.csv");

  std::vector<double> nx;
  for (const Row& row : table.rows) nx.push_back(row.n[0]);
  EXPECT_THAT(nx, ElementsAre(-1, 1, 1, 1, 1));
}

TEST(Rows, NumbersOfRowsAreTheirOwn) {
  EXPECT_THAT(MessagesOf("row,campaign,cmd_x_mm,value_mm\n1,a,1,0\n1,a,2,0\n,a,3,0\n"),
              StrEq("d.csv:3:1: row = 1 stands in line 2 already\n"
                    "  a row's number tells it from the others\n"
                    "d.csv:4:1: row is empty or no number\n"
                    "  number every row, or leave the column out: then they count in "
                    "file order"));
}

TEST(Rows, AKindThatIsNotKnownIsAFault) {
  EXPECT_THAT(
      MessagesOf("kind,campaign,cmd_x_mm,value_mm\nposition,a,1,0\ntuoch,a,1,0\n"),
      StrEq("d.csv:3:1: kind = 'tuoch' is not known\n"
            "  did you mean 'touch'? It may be: position, touch, radial"));
}

TEST(Rows, WhatIsNoTableOfRowsIsRefused) {
  EXPECT_THAT(MessagesOf(""),
              HasSubstr("d.csv:1:1: no measured rows: the file is empty"));
  EXPECT_THAT(MessagesOf("# comment\n"), HasSubstr("the file is empty"));
  EXPECT_THAT(MessagesOf("campaign,cmd_x_mm,value_mm\n"),
              StrEq("d.csv:1:1: no measured rows: only a header stands here"));
  EXPECT_THAT(
      MessagesOf("campaign;cmd_x_mm;value_mm\na;1;0,5\n"),
      StrEq("d.csv:1:1: this is no header of measured rows: no column is known\n"
            "  columns are separated by commas"));
  EXPECT_THAT(MessagesOf("1,2,3\n"),
              HasSubstr("this is no header of measured rows: no column is known"));
  EXPECT_THAT(MessagesOf(std::string("camp\0", 5)),
              StrEq("d.csv:1:5: a zero byte: this is not a text file"));
}

TEST(Rows, AHundredMegabytesAreRefusedWithoutReadingThem) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "caltwin_large.csv";
  WriteTextFile(file, "x");
  std::filesystem::resize_file(file, 100'000'000);  // Sparse: no byte is written.

  try {
    ReadRows(file);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(
        error.what(),
        HasSubstr("larger than any file of this kind (at most 64000000 bytes)"));
  }
  std::filesystem::remove(file);
}

TEST(Rows, ReadingStopsWhereNoOneReadsTheFaultsAnyMore) {
  std::string text = "campaign,cmd_x_mm,value_mm\n";
  for (int i = 0; i < 5000; ++i) text += "a,x,1\n";
  try {
    ParseRows(text, "d.csv");
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_LE(error.faults().size(), 1001u);
    EXPECT_GE(error.faults().size(), 1000u);
  }
}

}  // namespace
}  // namespace caltwin
