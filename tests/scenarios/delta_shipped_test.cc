#include "scenarios/kinds/delta_shipped.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/klipper_descent.h"
#include "scenarios/kinds/compare_delta.h"
#include "sim/base/input_error.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/measure/import/printer_cfg.h"

namespace caltwin {
namespace {

/// What the host has saved of its touches: whole steps down from the endstops.
std::vector<DeltaTouch> SavedTouches(const std::string& printer_cfg, double step_mm) {
  const PrinterCfg cfg(printer_cfg, "printer.cfg");
  std::vector<DeltaTouch> touches;
  for (int i = 0;; ++i) {
    const CfgSetting* const saved =
        cfg.Find("delta_calibrate", fmt::format("height{}_pos", i));
    if (saved == nullptr) return touches;
    std::istringstream numbers(saved->value.text);
    DeltaTouch touch;
    for (double& motor_mm : touch.motors_mm) {
      char comma = ',';
      numbers >> motor_mm >> comma;
      motor_mm *= step_mm;
    }
    touches.push_back(touch);
  }
}

// What is saved of a delta, angles in degrees.
std::array<double, 7> SavedOf(const DeltaModel<double>& model) {
  return {model.radius_mm[0],
          model.endstop_mm[0],
          model.endstop_mm[1],
          model.endstop_mm[2],
          DegFromRad(model.angle_rad[0]),
          DegFromRad(model.angle_rad[1]),
          DegFromRad(model.angle_rad[2])};
}

constexpr double kStep_mm = 0.0125;

/// What our own descent makes of those touches, each off by the rounding of a
/// thousandth of a step: a list for each number that is saved.
std::array<std::vector<double>, 7> OursOver(const std::vector<DeltaTouch>& saved) {
  constexpr double kRounded_steps = 5e-4;
  constexpr int kDraws = 200;
  Rng rng(1, 0, "rounded");
  std::array<std::vector<double>, 7> ours;
  for (int draw = 0; draw < kDraws; ++draw) {
    auto touches = saved;
    for (DeltaTouch& touch : touches) {
      for (double& motor_mm : touch.motors_mm) {
        motor_mm += kStep_mm * kRounded_steps * (2 * rng.Uniform() - 1);
      }
    }
    const auto found =
        SavedOf(FitKlipper(touches, {}, SymmetricDelta(300, 130, 250)).settings);
    for (std::size_t k = 0; k < found.size(); ++k) ours[k].push_back(found[k]);
  }
  return ours;
}

// That rounding turns the descent's path: it ends somewhere within its last steps of
// 1e-5. So the shipped result has to lie where our own descents lie.
//
// ctest runs it where the host is installed: Klipper.DescentIsTheShipped.
TEST(Shipped, OurDescentOverItsTouchesSavesWhatKalicoSaves) {
  const char* const host = std::getenv("CALTWIN_KLIPPER_HOST");
  if (host == nullptr || !std::filesystem::exists(host)) {
    GTEST_SKIP() << "CALTWIN_KLIPPER_HOST names no host";
  }
  constexpr double kRadius_mm = 100, kPrinted = 1e-6, kMost = 1e-4;
  for (int i = 0; i < 3; ++i) {
    const DeltaCase machine = RandomDelta(1, i);
    const DeltaOutcome shipped = CalibrateByKalico(
        {.build = machine.build, .bed = machine.bed, .scatter_mm = 0.01},
        kRadius_mm,
        7);
    ASSERT_TRUE(shipped.is_done) << shipped.messages.front();
    const auto saved = SavedTouches(shipped.messages.front(), kStep_mm);
    ASSERT_EQ(saved.size(), 7U);
    const auto ours = OursOver(saved);
    const auto theirs = SavedOf(shipped.settings);
    for (std::size_t k = 0; k < theirs.size(); ++k) {
      const auto [least, most] = std::ranges::minmax(ours[k]);
      EXPECT_LT(most - least, kMost) << k;
      EXPECT_GE(theirs[k], least - kPrinted) << k;
      EXPECT_LE(theirs[k], most + kPrinted) << k;
    }
  }
}

TEST(CompareDelta, OnlyEnginesThatAreNamedRun) {
  const DeltaComparison comparison =
      CompareDelta(1, 1, [](int) {}, {"rrf_8_factors", "g33", "g33"});
  ASSERT_EQ(comparison.engines.size(), 2U);
  EXPECT_EQ(comparison.engines[0].name, "rrf_8_factors");
  EXPECT_EQ(comparison.engines[1].name, "g33");
  EXPECT_EQ(ContendersOf(comparison).size(), 2U);
}

TEST(CompareDelta, AnEngineThatThereIsNotIsRefusedWithAllThatThereAre) {
  try {
    CompareDelta(1, 1, [](int) {}, {"clipper"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("there is no engine 'clipper'"));
    EXPECT_THAT(error.what(), testing::HasSubstr("kalico"));
  }
}

}  // namespace
}  // namespace caltwin
