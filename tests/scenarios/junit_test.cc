#include "scenarios/junit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::StrEq;

TEST(JUnit, HasATestCaseForEachExpectation) {
  RunResult result{.scenario = "scenarios/a&b.yaml", .seed = 3, .cpu_s = 0.25};
  result.parameters = {{.name = "backlash.x",
                        .unit = "mm",
                        .injected = 0.05,
                        .recovered = 0.0601,
                        .error = 0.0101,
                        .tolerance = 0.005,
                        .passed = false,
                        .identifiable = true},
                       {.name = "bed_tilt.slope_x_mrad"}};
  result.checks = {
      {.name = "outcome", .expected = "recovers", .found = "recovers", .passed = true}};

  EXPECT_THAT(
      JUnitText(std::span(&result, 1)),
      StrEq("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<testsuites>\n"
            "  <testsuite name=\"scenarios/a&amp;b.yaml seed 3\" tests=\"2\" "
            "failures=\"1\" errors=\"0\" time=\"0.250\">\n"
            "    <testcase classname=\"a&amp;b\" name=\"backlash.x\" time=\"0\">\n"
            "      <failure message=\"injected 0.0500 mm, recovered 0.0601, tolerance "
            "0.0050\"/>\n"
            "    </testcase>\n"
            "    <testcase classname=\"a&amp;b\" name=\"outcome\" time=\"0\"/>\n"
            "  </testsuite>\n"
            "</testsuites>\n"));
}

TEST(JUnit, EscapesWhatXmlCannotCarry) {
  EXPECT_THAT(XmlEscaped("a<b>&\"'\n\x01z"),
              StrEq("a&lt;b&gt;&amp;&quot;&apos;&#10;?z"));
}

}  // namespace
}  // namespace caltwin
