#include "sim/base/input_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::StrEq;

TEST(Place, LeavesOutWhatIsUnknown) {
  EXPECT_EQ(ToString({.file = "f.csv", .line = 3, .column = 7}), "f.csv:3:7");
  EXPECT_EQ(ToString({.file = "f.csv", .line = 3}), "f.csv:3");
  EXPECT_EQ(ToString({.file = "f.csv"}), "f.csv");
  EXPECT_EQ(ToString(Place{}), "");
}

TEST(Faults, AreThrownTogetherInTheirOrder) {
  Faults faults;
  faults.Add({.file = "f", .line = 1, .column = 2}, "first", "a hint");
  faults.Add({}, "second");

  try {
    faults.ThrowIfAny();
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.faults(), ElementsAre("f:1:2: first\n  a hint", "second"));
    EXPECT_THAT(error.what(), StrEq("f:1:2: first\n  a hint\nsecond"));
  }
}

TEST(Faults, NoneThrowNothing) {
  EXPECT_NO_THROW(Faults().ThrowIfAny());
}

TEST(FaultsText, ShowsTwentyAndCountsTheRest) {
  Faults few, many;
  for (int i = 0; i < 20; ++i) few.Add({}, "x");
  for (int i = 0; i < 23; ++i) many.Add({}, "x");
  const auto text_of = [](const Faults& faults) {
    try {
      faults.ThrowIfAny();
    } catch (const InputError& error) {
      return FaultsText(error);
    }
    return std::string();
  };

  std::string twenty;
  for (int i = 0; i < 20; ++i) twenty += "x\n";

  EXPECT_EQ(text_of(few), twenty);
  EXPECT_EQ(text_of(many), twenty + "and 3 more\n");
}

TEST(NearestWord, OffersASimilarWordOnly) {
  const std::vector<std::string> known = {"backlash_mm", "steps_per_mm", "axes", "x"};

  EXPECT_EQ(NearestWord("backlahs_mm", known), "backlash_mm");
  EXPECT_EQ(NearestWord("axis", known), "axes");
  EXPECT_EQ(NearestWord("step_per_m", known), "steps_per_mm");
  EXPECT_THAT(NearestWord("temperature", known), IsEmpty());
  EXPECT_THAT(NearestWord("q", known), IsEmpty());
  EXPECT_THAT(NearestWord("", known), IsEmpty());
}

}  // namespace
}  // namespace caltwin
