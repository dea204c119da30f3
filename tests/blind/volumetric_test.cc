#include "tests/blind/volumetric.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace blind {
namespace {

using ::testing::HasSubstr;

double Largest_mm(const Case& unseen) {
  double largest_mm = 0;
  for (const Reading& reading : unseen.readings) {
    largest_mm = std::max(largest_mm, std::abs(reading.value_mm));
  }
  return largest_mm;
}

// Wander, clutter and outliers of the case are no error of the machine.
TEST(Volumetric, OnlyWhatIsHiddenActs) {
  Case made;
  MakeCase({.kind = "single", .hidden = {{"squareness", "C0Y", 20}}, .seed = 5}, &made);
  made.truth.scale = made.truth.gap_mm = {};
  Case unseen;
  MakeUnseen(made, &unseen);
  EXPECT_EQ(unseen.readings.size(), 360U);
  EXPECT_GT(Largest_mm(unseen), 0.005);

  made.hidden.clear();
  Case nothing;
  MakeUnseen(made, &nothing);
  EXPECT_LT(Largest_mm(nothing), 1e-4);
}

TEST(Volumetric, TheMedianIsWhatCounts) {
  std::vector<Volumetric> all;
  for (const double after_um : {1.0, 2.0, 9.0}) {
    all.push_back({.name = "squareness C0Y",
                   .sigma = 3,
                   .seed = 7,
                   .ran = true,
                   .before_um = 10,
                   .after_um = after_um});
  }
  EXPECT_THAT(VolumetricText(all),
              HasSubstr("| 3 sigma | 80.0 % | 10.0 % | 3 | 70 % |"));
  EXPECT_THAT(VolumetricText(all),
              HasSubstr("| squareness C0Y | 3 | 7 | 10.00 | 9.00 | 10 % |"));
  all[1].ran = false;
  EXPECT_THAT(VolumetricText(all), HasSubstr("no answer"));
}

}  // namespace
}  // namespace blind
