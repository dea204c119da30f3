// Several fits of one set of measures in one text.

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

Imported Read(const std::string& text) {
  return ImportText(KindOrFound("", text, "f"), text, "f", {.tells_blunders = true});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

std::string Fitted(double arm_mm) {
  std::string text = "a fit\n";
  for (const char tower : {'a', 'b', 'c'}) {
    text += fmt::format("stepper_{}: position_endstop: 300 angle: 90 arm_length: {}\n",
                        tower,
                        tower == 'b' ? 300.0 : arm_mm);
  }
  return text;
}

TEST(Blunders, TwoFitsOfTheSameMeasuresConvictTheSoftware) {
  const std::string once = "DELTA_ANALYZE OUTER_DISTS=74.1,74.2,74.0\n";
  EXPECT_NE(NoteOf(Read(once + Fitted(950) + Fitted(301)), "firmware"), nullptr);
  EXPECT_EQ(NoteOf(Read(once + Fitted(950)), "firmware"), nullptr);
  EXPECT_NE(NoteOf(Read(once + Fitted(950)), "file"), nullptr);
  const std::string anew = "DELTA_ANALYZE OUTER_DISTS=74.1,74.2,73.9\n";
  EXPECT_NE(NoteOf(Read(once + Fitted(950) + anew + Fitted(301)), "file"), nullptr);
}

}  // namespace
}  // namespace caltwin
