#include "calibration/diagnosis/stated_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kSigma_um = 0.5;
constexpr double kThousandths = 1 / MmFromInch(1.0);  // Of an inch, in a um.

// A laser stated at half a micrometre reads a straight axis, its readings written
// `times` as large.
Observed Read(double times) {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  RowTable table;
  Rng rng(1, 0, "stated noise");
  for (int i = 0; i < 60; ++i) {
    Row row{.row = i + 1, .campaign = "laser", .rep = i / 20 + 1};
    row.cmd_mm = {10.0 * (i % 20), 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = times * MmFromUm(kSigma_um * rng.Normal());
    table.rows.push_back(row);
  }
  DataHeader header;
  header.instruments["laser"] = {.kind = "laser", .sigma_um = kSigma_um};
  header.campaigns["laser"] = {.instrument = "laser"};
  return {table, header, machine, {}};
}

TEST(StatedNoise, ReadingsInThousandthsAreTold) {
  EXPECT_THAT(
      Diagnose(Read(1000 * kThousandths), {}).remarks,
      Contains(AllOf(HasSubstr("laser by "), HasSubstr("value_mm in thousandths"))));
}

TEST(StatedNoise, ReadingsInMicrometresAreTold) {
  EXPECT_THAT(Diagnose(Read(1000), {}).remarks,
              Contains(HasSubstr("may be in another unit")));
}

TEST(StatedNoise, AnInstrumentThreeTimesWorseIsNoUnit) {
  EXPECT_THAT(Diagnose(Read(3), {}).remarks, IsEmpty());
}

}  // namespace
}  // namespace caltwin
