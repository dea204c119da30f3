#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/kinds/compare_measured.h"

namespace caltwin {
namespace {

// Each row of the machine measured elsewhere, 200 draws of those with noise: what is
// not met is known and explained, and nothing else.
TEST(CompareMeasured, EveryRowIsMetButThoseExplained) {
  std::vector<std::string> missed;
  for (const MeasuredTask& task : CompareMeasuredDelta(200, 1, [](const auto&) {})) {
    for (const MeasuredFigure& figure : task.figures) {
      if (figure.is_met) continue;
      missed.push_back(task.engine + " " + task.task + ": " + figure.name);
      EXPECT_NE(task.note, "") << missed.back();
    }
  }

  EXPECT_THAT(missed,
              ::testing::UnorderedElementsAre("rrf 6 factors, 10 um: z rms um",
                                              "rrf 7 factors, rods, 10 um: rod rms um",
                                              "rrf 6 factors, tilt, one run: z rms um",
                                              "rrf 8 factors, tilt: z rms um",
                                              "g33 P4, 10 um: z rms um"));
}

}  // namespace
}  // namespace caltwin
