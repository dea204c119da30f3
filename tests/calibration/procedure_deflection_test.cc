#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/procedures/deflection.h"
#include "calibration/procedures/release_backlash.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::RunStep;
using testing::ToyBench;

constexpr double kStep_mm = 1 / 800.0;

double DeflectionNow(const ToyBench& toy, int axis) {
  const std::string text = toy.machine.globals.at("nxtProbeDeflection");
  std::vector<double> numbers;
  for (std::size_t at = text.find_first_of("{,"); at != std::string::npos;
       at = text.find(',', at + 1)) {
    numbers.push_back(std::stod(text.substr(at + 1)));
  }
  return numbers.at(static_cast<std::size_t>(axis));
}

TEST(Deflection, CorrectedFindsThePretravelOfAKnownGap) {
  ToyBench toy;
  toy.machine.drives[0] = {.gap_mm = 0.05, .pretravel_mm = 0.03};

  const ProcedureResult result =
      RunStep(kDeflection, "{axis: x, backlash_left_mm: 0.05, tip_radius_mm: 1}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(DeflectionNow(toy, 0), 0.03, kStep_mm);
  EXPECT_EQ(DeflectionNow(toy, 1), 0);
}

TEST(Deflection, TakesTheGapFromTheReleaseMeasuredBefore) {
  ToyBench toy;
  toy.machine.drives[1] = {.gap_mm = 0.08, .pretravel_mm = 0.015};

  RunStep(kTriggerReleaseBacklash, "{axis: y}", &toy);
  const ProcedureResult result = RunStep(kDeflection, "{axis: y}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(DeflectionNow(toy, 1), 0.015, 2 * kStep_mm);
}

TEST(Deflection, SaysThatItCannotTellAnUnknownGap) {
  ToyBench toy;

  const ProcedureResult result = RunStep(kDeflection, "{axis: x}", &toy);

  EXPECT_EQ(result.ending, Ending::kConfounded);
  EXPECT_FALSE(result.estimates.at(0).identifiable);
  EXPECT_TRUE(toy.machine.globals.empty());
}

TEST(Deflection, OfABoreIsThatOfABlock) {
  ToyBench toy;
  toy.machine.drives[0].pretravel_mm = 0.03;
  toy.bench.artefacts = {{.id = "pocket",
                          .type = ArtefactType::kPocket,
                          .at_mm = {150, 150, 0},
                          .size_mm = {40, 40, 20}}};
  toy.machine.artefacts.clear();
  for (const double wall_mm : {150 - 27.5, 150 + 27.5}) {
    toy.machine.artefacts.push_back(
        {.id = "wall", .at_mm = {wall_mm, 150, 0}, .size_mm = {15, 70, 20}});
  }

  const ProcedureResult result =
      RunStep(kDeflection, "{axis: x, backlash_left_mm: 0, tip_radius_mm: 1}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(DeflectionNow(toy, 0), 0.03, kStep_mm);
}

TEST(Deflection, AsPublishedStoresTheWrongSignInOneNumber) {
  ToyBench toy;
  toy.machine.drives[0] = {.gap_mm = 0.05, .pretravel_mm = 0.03};

  const ProcedureResult result =
      RunStep(kDeflection, "{axis: x, variant: as_published}", &toy);

  EXPECT_NEAR(std::stod(toy.machine.globals.at("nxtProbeDeflection")),
              -(0.03 + 0.025),
              kStep_mm);
  EXPECT_THAT(result.messages, Contains(HasSubstr("agrees with itself")));
}

TEST(Deflection, AlongZNeedsALedge) {
  ToyBench toy;

  const ProcedureResult result = RunStep(kDeflection, "{axis: z}", &toy);

  EXPECT_EQ(result.ending, Ending::kConfounded);
  EXPECT_FALSE(result.estimates.at(0).identifiable);
  EXPECT_THAT(result.messages, Contains(HasSubstr("needs a ledge")));
}

TEST(Deflection, AsksWhetherTheDiameterWasEntered) {
  ToyBench toy;
  toy.bench.instruments["calliper"] = {.kind = "calliper", .resolution_um = 10};
  toy.machine.settings.tip_radius_mm = 2;
  toy.bench.machine.settings.tip_radius_mm = 2;

  const ProcedureResult result =
      RunStep(kDeflection, "{axis: x, backlash_left_mm: 0, apply: false}", &toy);

  EXPECT_THAT(result.messages, Contains(HasSubstr("entered as the radius")));
  EXPECT_NEAR(result.estimates.at(0).value, 0.02, kStep_mm);
}

}  // namespace
}  // namespace caltwin
