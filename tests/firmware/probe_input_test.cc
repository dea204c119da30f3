#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/bench.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kAsk[] = R"(M409 K"sensors.probes[0].value[0]")";
constexpr char kTowards[] = "G38.2 X110 F300";

// What is read of the probe in the air, and what a probe move towards a wall at 105 mm
// says.
std::vector<std::string> Answers(ProbeInput probe) {
  FirmwareBench bench({.probe = probe});
  bench.HomeAndCentre();
  bench.plant.wall_mm = 105;
  std::vector<std::string> said = bench.Say({kAsk});
  for (const std::string& line : bench.Say({kTowards})) said.push_back(line);
  return said;
}

TEST(ProbeInput, AsItShouldItReadsFreeAndFindsTheWall) {
  EXPECT_THAT(Answers(ProbeInput::kWired), ElementsAre(HasSubstr("\"result\":0")));
}

TEST(ProbeInput, MissingIsNotListedAndRefused) {
  EXPECT_THAT(Answers(ProbeInput::kMissing),
              ElementsAre(HasSubstr("\"result\":null"),
                          "Error: G38.2: no Z probe is configured"));
}

TEST(ProbeInput, StuckReadsTriggeredInTheAir) {
  EXPECT_THAT(Answers(ProbeInput::kStuck),
              ElementsAre(HasSubstr("\"result\":1000"),
                          HasSubstr("already triggered before probing move")));
}

TEST(ProbeInput, OpenGoesThroughTheWall) {
  EXPECT_THAT(Answers(ProbeInput::kOpen),
              ElementsAre(HasSubstr("\"result\":0"), HasSubstr("was not triggered")));
}

}  // namespace
}  // namespace caltwin
