#include "sim/measure/import/printer_cfg.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

TEST(PrinterCfg, TellsAllThatWasSaved) {
  const PrinterCfg cfg(
      "[probe]\nz_offset = 1\n#*# <---------------------- SAVE_CONFIG ------>\n"
      "#*# DO NOT EDIT THIS BLOCK OR BELOW.\n#*#\n#*# [probe]\n#*# z_offset = -3.800\n"
      "#*#\n#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n"
      "#*# \t  0.1, 0.2\n#*# \t  0.3, 0.4\n#*# min_x = 30\n",
      "printer.cfg");

  const auto saved = cfg.AllSaved();

  ASSERT_EQ(saved.size(), 4U);  // By section and key.
  EXPECT_EQ(saved[0].section, "bed_mesh default");
  EXPECT_EQ(saved[0].key, "min_x");
  EXPECT_EQ(saved[0].value, "30");
  EXPECT_EQ(saved[1].key, "points");
  EXPECT_EQ(saved[1].value, "0.1, 0.2\n0.3, 0.4");
  EXPECT_EQ(saved[3].section, "probe");
  EXPECT_EQ(saved[3].key, "z_offset");
  EXPECT_EQ(saved[3].value, "-3.800");
}

TEST(PrinterCfg, WhatIsNoSavedPartTellsNothing) {
  for (const char* const text :
       {"", "#*#", "#*# [", "#*# \t1, 2", "[probe]\nx = 1\n"}) {
    EXPECT_TRUE(PrinterCfg(text, "printer.cfg").AllSaved().empty()) << text;
  }
}

}  // namespace
}  // namespace caltwin
