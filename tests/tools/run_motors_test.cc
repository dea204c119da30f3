#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/rows.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(RunOfMotors, HasNoRowsToRecord) {
  const TempFolder folder;
  const fs::path rows = folder / "rows.csv";

  const Answer answer = RunCommand(
      DeclareRun,
      {CALTWIN_SOURCE_DIR "/scenarios/motor_factory_reset.yaml", "--record", rows});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("touches nothing: motors have no rows"));
  EXPECT_FALSE(fs::exists(rows));
}

TEST(RunOfAZOffset, WritesItsTouchesAndGapsAsRows) {
  const TempFolder folder;
  const fs::path rows = folder / "rows.csv";

  const Answer answer = RunCommand(
      DeclareRun,
      {CALTWIN_SOURCE_DIR "/scenarios/z_offset_diagnosed_ooze.yaml", "--record", rows});

  EXPECT_EQ(answer.exit_code, 0) << answer.fault;
  // Eight calibrations of three touches three times, three descents of six gaps.
  EXPECT_EQ(ReadRows(rows).rows.size(), 8U * 9 + 3 * 6);
}

}  // namespace
}  // namespace caltwin
