// Names that the rows seem to give, and what they are worth.
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr double kSigma_mm = 1e-3;
constexpr double kStart_c = 20;

Machine Plain() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// Rises and settles within `duration_s`.
double Warming(double t_s, double duration_s) {
  return 1 - std::exp(-3 * t_s / duration_s);
}

std::vector<std::string> Named(const RowTable& table,
                               const Machine& machine = Plain()) {
  const Diagnosis diagnosis = Diagnose(Observed(table, {}, machine, {}), {});
  std::vector<std::string> names;
  for (const Finding& finding : diagnosis.findings) names.push_back(finding.cause);
  return names;
}

// A laser along x, again and again, while the screw warms by `warmer_k` and the far end
// moves by 24 um.
RowTable LongerAxis(double warmer_k) {
  constexpr int kRuns = 16, kPositions = 10;
  constexpr double kGrowth_mm = 0.024, kStep_s = 30;
  Rng rng(21, 0, "names_test");
  RowTable table;
  for (int i = 0; i < kRuns * kPositions; ++i) {
    const double warmth = Warming(kStep_s * i, kStep_s * kRuns * kPositions);
    const double share = static_cast<double>(i % kPositions) / (kPositions - 1);
    Row row{.row = i + 1, .campaign = "laser"};
    row.t_s = kStep_s * i;
    row.temp_screw_c = kStart_c + warmer_k * warmth;
    row.cmd_mm = {300 * share, 0, 0};
    row.dir = {i / kPositions % 2 == 0 ? 1.0 : -1.0, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = kGrowth_mm * share * warmth + kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return table;
}

// A laser along x at random places: a wave of each screw turn on a smooth run of the
// pitch.
RowTable WaveOnABend(double wave_mm, double bend_mm) {
  constexpr int kPlaces = 60;
  constexpr double kLead_mm = 4;
  Rng rng(23, 0, "names_test");
  RowTable table;
  for (int i = 0; i < 2 * kPlaces; ++i) {
    const int place = i / 2;
    const double u = std::fmod(0.5 + 0.61803398875 * place, 1.0);
    Row row{.row = i + 1, .campaign = "laser"};
    row.t_s = 10 * i;
    row.rep = 1 + i % 2;
    row.cmd_mm = {300 * u, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    const double v = 2 * u - 1;
    const double turn_rad = 2 * std::numbers::pi * row.cmd_mm[0] / kLead_mm;
    row.value_mm = wave_mm * std::sin(turn_rad) + bend_mm * (4 * v * v * v - 3 * v) +
                   kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return table;
}

// Faces touched in turn while the probe's trigger point moves by 15 um in 4 K.
RowTable WarmProbe(const std::vector<std::array<double, 3>>& normals) {
  constexpr int kRounds = 40;
  constexpr double kDrift_mm = 0.015, kStep_s = 40, kWarmer_k = 4;
  Rng rng(22, 0, "names_test");
  RowTable table;
  const double duration_s = kStep_s * kRounds * static_cast<double>(normals.size());
  for (int i = 0; i < kRounds; ++i) {
    for (std::size_t k = 0; k < normals.size(); ++k) {
      const auto count = static_cast<double>(table.rows.size());
      const double warmth = Warming(kStep_s * count, duration_s);
      const auto& n = normals[k];
      Row row{.row = static_cast<std::int64_t>(count) + 1, .campaign = "faces"};
      row.kind = RowKind::kTouch;
      row.setup = "face" + std::to_string(k);
      row.t_s = kStep_s * count;
      row.temp_screw_c = kStart_c + kWarmer_k * warmth;
      row.cmd_mm = {100 + 20 * n[0], 100, 50 + 10 * n[2]};
      row.dir = {-n[0], 0, -n[2]};
      row.n = n;
      row.feed_mm_s = 1;
      row.value_mm = -kDrift_mm * warmth + kSigma_mm * rng.Normal();
      table.rows.push_back(row);
    }
  }
  return table;
}

TEST(Names, AScrewGrowsAsMaterialsDo) {
  EXPECT_THAT(Named(LongerAxis(6)), ElementsAre("thermal_screw"));
  EXPECT_THAT(Named(LongerAxis(0.3)), Not(Contains("thermal_screw")));
}

TEST(Names, AProbeIsToldFromPlayOnFacesOfTwoAxes) {
  EXPECT_THAT(Named(WarmProbe({{-1, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, -1}})),
              ElementsAre("probe_temperature"));
  EXPECT_THAT(Named(WarmProbe({{-1, 0, 0}, {1, 0, 0}})), ElementsAre("unknown"));
}

// A smooth table is no deviation of a wave far finer than its terms, however tall. Of a
// machine that is only assumed, no lead is known: no table is its pitch's.
TEST(Names, AWaveStandsBesideATallerPitchMap) {
  Machine drawn = Plain();
  drawn.file = "machine.yaml";
  const RowTable both = WaveOnABend(0.006, 0.012);
  EXPECT_THAT(Named(both, drawn), UnorderedElementsAre("cyclic_lead", "pitch_map"));
  EXPECT_THAT(Named(both), UnorderedElementsAre("cyclic_lead", "unknown"));
  EXPECT_THAT(Named(WaveOnABend(0.006, 0), drawn), ElementsAre("cyclic_lead"));
}

}  // namespace
}  // namespace caltwin
