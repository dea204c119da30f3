// One bad reading of a real axis is left out, and it alone.
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<long> LeftOut(const std::function<void(RowTable*)>& spoil) {
  RowTable table = ReadRows(std::string(CALTWIN_SOURCE_DIR) +
                            "/tests/data/iso230/ess_target_x_2022-04.csv");
  spoil(&table);
  Machine machine;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  return Diagnose(Observed(table, {}, machine, {}), {}).outlier_rows;
}

TEST(Outliers, NoneIsFoundWhereNoneIs) {
  EXPECT_THAT(LeftOut([](RowTable*) {}), IsEmpty());
}

class OneBadRow : public ::testing::TestWithParam<int> {};

TEST_P(OneBadRow, IsLeftOutAndItAlone) {
  const int bad = GetParam();
  const auto spoilt = [bad](double by_mm, double sense) {
    return LeftOut([&](RowTable* table) {
      Row& row = table->rows[static_cast<std::size_t>(bad) - 1];
      row.value_mm += by_mm;
      row.dir[0] *= sense;
    });
  };
  EXPECT_THAT(spoilt(0.5, 1), ElementsAre(bad));
  EXPECT_THAT(spoilt(0.05, 1), ElementsAre(bad));
  EXPECT_THAT(spoilt(0, -1), ElementsAre(bad));  // Written down with the wrong sense.
}

INSTANTIATE_TEST_SUITE_P(Outliers, OneBadRow, ::testing::Values(20, 40, 77));

}  // namespace
}  // namespace caltwin
