#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/caltwin_process.h"

namespace caltwin {
namespace {

using testing::Eq;
using testing::HasSubstr;

TEST(KlipperCommand, NewWritesAPrinterCfgAndNoSecondOverIt) {
  const TempFolder folder;
  const std::string file = (folder.path() / "printer.cfg").string();

  const Finished first = Caltwin("new klipper delta_printer --out " + file);
  const Finished second = Caltwin("new klipper delta_printer --out " + file);

  EXPECT_THAT(first.code, Eq(0));
  EXPECT_THAT(ReadTextFile(file, kLargestFile_bytes), HasSubstr("[delta_calibrate]"));
  EXPECT_THAT(second.code, Eq(2));
  EXPECT_THAT(second.err, HasSubstr("this file is already there"));
}

TEST(KlipperCommand, AMachineThatItCannotDriveIsNamed) {
  const Finished run = Caltwin("new klipper motor_stage --out /dev/null/x.cfg");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err,
              HasSubstr("of kind motor_stage cannot yet be driven by Klipper"));
  EXPECT_THAT(run.err,
              HasSubstr("kinds that can: cartesian, delta, triple_z, z_station"));
}

TEST(KlipperCommand, NobodyElseSharesTheMachine) {
  const Finished run =
      Caltwin("serve --machine delta_printer --klipper /tmp/nowhere --tcp 0");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("Klipper's host alone drives the machine"));
}

TEST(KlipperCommand, APathThatIsTakenIsRefused) {
  const TempFolder folder;
  const std::string taken = (folder.path() / "taken").string();
  WriteTextFile(taken, "");

  const Finished run = Caltwin("serve --machine delta_printer --klipper " + taken);

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("--klipper " + taken + ": File exists"));
}

}  // namespace
}  // namespace caltwin
