#include "renders/html.h"

#include <cmath>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

// The test vectors of RFC 4648, section 10.
TEST(Base64, AgreesWithItsStandard) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foob"), "Zm9vYg==");
  EXPECT_EQ(Base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, TakesBytesAboveAscii) {
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

TEST(NumberText, ShowsTwoDigitsOfTheResolution) {
  EXPECT_EQ(NumberText(800.01234, 0.02), "800.012");
  EXPECT_EQ(NumberText(800.01234, 0.3), "800.01");
  EXPECT_EQ(NumberText(1234.5, 100), "1234");
  EXPECT_EQ(NumberText(0.05, 0.0004), "0.05000");
}

TEST(NumberText, WithoutAResolutionShowsFiveDigits) {
  EXPECT_EQ(NumberText(800.01234, 0), "800.01");
}

TEST(NumberText, SaysADashForWhatIsNotANumber) {
  EXPECT_EQ(NumberText(std::nan(""), 0.1), "–");
}

TEST(NumberText, HasNoNegativeZero) {
  EXPECT_EQ(NumberText(-0.0001, 0.1), "0.00");
  EXPECT_EQ(SignedText(-0.0001, 0.1), "0.00");
}

TEST(SignedText, SaysPlus) {
  EXPECT_EQ(SignedText(0.3, 0.1), "+0.30");
  EXPECT_EQ(SignedText(-0.3, 0.1), "-0.30");
}

TEST(Escaped, LeavesNothingOfMarkup) {
  EXPECT_EQ(Escaped("<a b=\"c\" d='e'>&"),
            "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;");
}

TEST(LengthText, ChoosesTheUnit) {
  EXPECT_EQ(LengthText(1.4321), "1.43 mm");
  EXPECT_EQ(LengthText(0.0041), "4.1 µm");
  EXPECT_EQ(LengthText(0), "under 0.01 µm");
}

TEST(DurationText, IsForPeople) {
  EXPECT_EQ(DurationText(42), "42 s");
  EXPECT_EQ(DurationText(512), "8 min 32 s");
  EXPECT_EQ(DurationText(119.7), "2 min 0 s");
  EXPECT_EQ(DurationText(7500), "2 h 5 min");
}

}  // namespace
}  // namespace caltwin
