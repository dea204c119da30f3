#include "tools/commands/assumed_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

RowTable RowsAlongX() {
  RowTable table;
  for (const double at_mm : {20.0, 80.0, 140.0}) {
    Row row;
    row.cmd_mm[0] = at_mm;
    table.rows.push_back(row);
  }
  return table;
}

// Moved too far by the setting over what was drawn, whoever set it.
TEST(AssumedMachine, RowsAreHeldAgainstTheSettingsTheyWereMeasuredUnder) {
  DataHeader header;
  header.settings["one"].steps_per_mm["x"] = 808;
  header.settings["two"].steps_per_mm["x"] = 808;
  header.settings["one"].steps_per_mm["y"] = 801;
  header.settings["two"].steps_per_mm["y"] = 802;
  Machine machine;
  machine.settings.steps_per_mm = {800, 800, 800};

  const Machine held = WithSettingsOf(machine, header);

  EXPECT_EQ(held.settings.steps_per_mm[0], 808);
  EXPECT_EQ(held.settings.steps_per_mm[1], 800);
  EXPECT_EQ(held.axis(Axis::kX).steps_per_mm(), machine.axis(Axis::kX).steps_per_mm());
}

TEST(AssumedMachine, TravelsAsFarAsTheRowsGoAndSaysSo) {
  std::vector<std::string> notes;
  const Machine machine = AssumedMachine(RowsAlongX(), &notes);

  EXPECT_EQ(machine.axis(Axis::kX).min_mm, 20);
  EXPECT_EQ(machine.axis(Axis::kX).max_mm, 140);
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0], HasSubstr("as far as the rows go (x 20 to 140 mm)"));
}

// The stated steps are as built: a twin of other steps would read everything scaled.
TEST(AssumedMachine, HasTheStepsThatTheHeaderSays) {
  std::vector<std::string> notes;
  DataHeader header;
  header.settings["s1"].steps_per_mm["x"] = 400;
  header.settings["s2"].steps_per_mm["x"] = 400;
  header.transmission["x"].lead_mm = 5;
  const Machine machine = WithStepsAsSet(
      WithTransmission(AssumedMachine(RowsAlongX(), &notes), header), header);

  EXPECT_DOUBLE_EQ(machine.axis(Axis::kX).lead_mm, 5);
  EXPECT_DOUBLE_EQ(machine.axis(Axis::kX).steps_per_mm(), 400);
  EXPECT_DOUBLE_EQ(machine.settings.steps_per_mm[0], 400);
}

TEST(AssumedMachine, KeepsItsStepsWhereSettingsDisagree) {
  std::vector<std::string> notes;
  const Machine assumed = AssumedMachine(RowsAlongX(), &notes);
  DataHeader header;
  header.settings["s1"].steps_per_mm["x"] = 400;
  header.settings["s2"].steps_per_mm["x"] = 404;

  EXPECT_EQ(WithStepsAsSet(assumed, header).axis(Axis::kX).steps_per_mm(),
            assumed.axis(Axis::kX).steps_per_mm());
}

}  // namespace
}  // namespace caltwin
