#include "calibration/facts/waves.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "sim/base/drifting_wave.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

// The axis along which these rows lie; none where they lie along two.
std::optional<std::size_t> AxisOf(const Rows& rows) {
  std::optional<std::size_t> along;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto is_elsewhere = [&](const Row* row) {
      return Known(row->cmd_mm[k]) && row->cmd_mm[k] != rows.front()->cmd_mm[k];
    };
    if (std::ranges::none_of(rows, is_elsewhere)) continue;
    if (along) return std::nullopt;
    along = k;
  }
  return along;
}

// Rows that one pass of one instrument would give.
std::map<std::string, Rows> PassesOf(const Rows& rows, const Repeats& repeats) {
  std::map<std::string, Rows> passes;
  for (const Row* row : rows) {
    if (repeats.outliers.contains(row->row)) continue;
    passes[fmt::format("{}|{}|{}|{}|{}",
                       static_cast<int>(row->kind),
                       row->campaign,
                       row->setup,
                       fmt::join(row->dir, ","),
                       fmt::join(row->n, ","))]
        .push_back(row);
  }
  return passes;
}

Fact FactOf(const DriftingWave& wave, std::size_t axis, double noise_mm) {
  const std::string repeats_to = Known(noise_mm)
                                     ? fmt::format(" and one reading repeats to {} um",
                                                   TwoDigits(UmFromMm(noise_mm)))
                                     : "";
  return {
      .id = "wave",
      .axis = kAxisNames[axis],
      .word = "drifting",
      .figures = {{"period_mm", wave.period},
                  {"least_period_mm", wave.least_period},
                  {"most_period_mm", wave.most_period},
                  {"size_um", UmFromMm(wave.size)},
                  {"least_size_um", UmFromMm(wave.least_size)},
                  {"most_size_um", UmFromMm(wave.most_size)},
                  {"share", wave.share}},
      .sentence = fmt::format(
          "Along {} the readings go up and down in a wave of {:.3g} mm whose period "
          "and "
          "size drift: {:.3g} to {:.3g} mm, +- {} to {} um. It is {:.0f} % of what a "
          "smooth curve leaves{}; a wave of one period would be {:.0f} %. A screw, a "
          "pulley or a tooth keeps its period, so it is none of these: look at what "
          "rolls or slips between both (balls of a guide, a friction wheel), and at "
          "the "
          "instrument and its trigger",
          "XYZ"[axis],
          wave.period,
          wave.least_period,
          wave.most_period,
          TwoDigits(UmFromMm(wave.least_size)),
          TwoDigits(UmFromMm(wave.most_size)),
          100 * wave.share,
          repeats_to,
          100 * wave.share_of_fixed),
      .is_answer = true};
}

}  // namespace

void FactsOfWaves(const Rows& rows, const Repeats& repeats, Facts* facts) {
  std::map<std::size_t, Fact> largest;
  for (const auto& [pass, members] : PassesOf(rows, repeats)) {
    const auto axis = AxisOf(members);
    if (!axis) continue;
    std::map<double, Rows> by_place;
    for (const Row* row : members) {
      if (Known(row->cmd_mm[*axis])) by_place[row->cmd_mm[*axis]].push_back(row);
    }
    Eigen::VectorXd at_mm(std::ssize(by_place)), value_mm(std::ssize(by_place));
    Eigen::Index i = 0;
    for (const auto& [place_mm, readings] : by_place) {
      at_mm[i] = place_mm;
      value_mm[i++] = AverageOf(readings).mean;
    }
    const auto wave = DriftingWaveOf(at_mm, value_mm);
    if (!wave) continue;
    const Fact fact = FactOf(*wave, *axis, repeats.NoiseOf(*members.front()).sd_mm);
    const auto known = largest.find(*axis);
    // Of several passes the one that it explains most of.
    if (known == largest.end() ||
        known->second.figures.back().value < fact.figures.back().value) {
      largest[*axis] = fact;
    }
  }
  for (const auto& [axis, fact] : largest) facts->all.push_back(fact);
}

}  // namespace caltwin
