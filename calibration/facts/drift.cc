#include "calibration/facts/drift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

// Kendall's tau against chance: normal, and exact where every step goes one way.
double TrendChance(const Rows& rows) {
  const double s = TrendSum(rows);
  const auto n = static_cast<double>(rows.size());
  if (std::abs(s) == n * (n - 1) / 2) return 2 / std::tgamma(n + 1);
  const double z = std::max(0.0, std::abs(s) - 1) / std::sqrt(TrendVariance(rows));
  return std::erfc(z / std::sqrt(2.0));
}

/// A temperature that went along with a drift.
struct Companion {
  std::string_view name{};
  double Row::*member = nullptr;
};
constexpr std::array kCompanions = {Companion{"frame", &Row::temp_frame_c},
                                    Companion{"bed", &Row::temp_bed_c},
                                    Companion{"chamber", &Row::temp_chamber_c},
                                    Companion{"nozzle", &Row::temp_nozzle_c},
                                    Companion{"screw", &Row::temp_screw_c},
                                    Companion{"room", &Row::temp_ambient_c}};

// What of the temperatures rose or fell by more than two kelvin from first to last.
std::string WarmedInWords(const Rows& rows) {
  constexpr double kLeast_k = 2;
  std::vector<std::string> parts;
  for (const Companion& one : kCompanions) {
    const double first_c = rows.front()->*one.member, last_c = rows.back()->*one.member;
    if (!Known(first_c) || !Known(last_c) || std::abs(last_c - first_c) < kLeast_k) {
      continue;
    }
    parts.push_back(fmt::format("the {} went from {:.4g} to {:.4g} degrees Celsius",
                                one.name,
                                first_c,
                                last_c));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

bool KnowsTemperature(const Rows& rows) {
  return std::ranges::any_of(kCompanions, [&](const Companion& one) {
    return Known(rows.front()->*one.member) && Known(rows.back()->*one.member);
  });
}

}  // namespace

double TrendSum(const Rows& rows) {
  double s = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = i + 1; j < rows.size(); ++j) {
      const double step_mm = rows[j]->value_mm - rows[i]->value_mm;
      s += step_mm > 0 ? 1 : step_mm < 0 ? -1 : 0;
    }
  }
  return s;
}

double TrendVariance(const Rows& rows) {
  const auto n = static_cast<double>(rows.size());
  return n * (n - 1) * (2 * n + 5) / 18;
}

Drift ChangeOf(const Rows& rows, double resolution_mm) {
  const std::vector<double> steps_mm = StepsOf(rows);
  const double mean_mm = std::accumulate(steps_mm.begin(), steps_mm.end(), 0.0) /
                         static_cast<double>(steps_mm.size());
  double squares_mm2 = 0;
  for (const double step_mm : steps_mm) squares_mm2 += std::pow(step_mm - mean_mm, 2);
  const double noise_mm =
      std::max(std::sqrt(squares_mm2 / static_cast<double>(steps_mm.size() - 1) / 2),
               resolution_mm / std::sqrt(12.0));
  const std::size_t num = std::max<std::size_t>(1, rows.size() / 10);
  const Rows first(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(num));
  const Rows last(rows.end() - static_cast<std::ptrdiff_t>(num), rows.end());
  Drift drift{.change_mm = MeanOf(last) - MeanOf(first),
              .sd_mm = noise_mm * std::sqrt(2 / static_cast<double>(num)),
              .noise_mm = noise_mm};
  return drift;
}

std::optional<Drift> DriftOf(const Rows& rows, double resolution_mm) {
  constexpr std::size_t kFewest = 6;
  constexpr double kMostChance = 3e-3, kLeastSigmas = 2;
  if (rows.size() < kFewest || TrendChance(rows) > kMostChance) return std::nullopt;
  const Drift drift = ChangeOf(rows, resolution_mm);
  if (std::abs(drift.change_mm) < kLeastSigmas * drift.sd_mm) return std::nullopt;
  return drift;
}

std::vector<Rows> AtOneStep(const Rows& rows, double resolution_mm) {
  constexpr std::ptrdiff_t kFewest = 4;
  constexpr double kOfLine = 0.5, kLeastSigmas = 6;
  const std::ptrdiff_t num = std::ssize(rows);
  std::vector<Rows> best;
  double least_mm2 = HUGE_VAL;
  for (std::ptrdiff_t k = kFewest; k + kFewest <= num; ++k) {
    const Rows before(rows.begin(), rows.begin() + k),
        after(rows.begin() + k, rows.end());
    const double within_mm2 =
        SquaresAbout(before, MeanOf(before)) + SquaresAbout(after, MeanOf(after));
    if (within_mm2 >= least_mm2) continue;
    least_mm2 = within_mm2;
    best = {before, after};
  }
  if (best.empty()) return {};
  double nn = 0, nz = 0;
  const double mean_mm = MeanOf(rows), middle = static_cast<double>(num - 1) / 2;
  for (std::ptrdiff_t i = 0; i < num; ++i) {
    const double n = static_cast<double>(i) - middle;
    nn += n * n;
    nz += n * (rows[static_cast<std::size_t>(i)]->value_mm - mean_mm);
  }
  const double of_line_mm2 = SquaresAbout(rows, mean_mm) - nz * nz / nn;
  const double sd_mm = std::max(std::sqrt(least_mm2 / static_cast<double>(num - 3)),
                                resolution_mm / std::sqrt(12.0));
  const double change_mm = std::abs(MeanOf(best[1]) - MeanOf(best[0]));
  const bool is_step =
      least_mm2 < kOfLine * of_line_mm2 && change_mm > kLeastSigmas * sd_mm &&
      !DriftOf(best[0], resolution_mm) && !DriftOf(best[1], resolution_mm);
  return is_step ? best : std::vector<Rows>{};
}

bool IsWarmed(const Rows& rows) {
  constexpr double kApart_k = 5;
  return std::ranges::any_of(kCompanions, [&](const Companion& one) {
    double least_c = HUGE_VAL, most_c = -HUGE_VAL;
    for (const Row* row : rows) {
      const double at_c = row->*one.member;
      if (!Known(at_c)) continue;
      least_c = std::min(least_c, at_c);
      most_c = std::max(most_c, at_c);
    }
    return most_c - least_c > kApart_k;
  });
}

void AddDrift(const Rows& rows, const Drift& drift, Facts* facts) {
  const std::vector<double> steps_mm = StepsOf(rows);
  const auto along = std::ranges::count_if(
      steps_mm, [&](double step_mm) { return step_mm * drift.change_mm > 0; });
  Fact fact{
      .id = "drift",
      .figures = {{"change_um", UmFromMm(drift.change_mm), UmFromMm(drift.sd_mm)}},
      .sigmas = std::abs(drift.change_mm) / std::max(drift.sd_mm, 1e-9),
      .is_answer = true};
  std::string over = fmt::format("{} readings", rows.size());
  const double time_s = rows.back()->t_s - rows.front()->t_s;
  if (Known(time_s) && time_s > 0) {
    fact.figures.push_back({"time_s", time_s});
    over += time_s < 600 ? fmt::format(" ({:.0f} s)", time_s)
                         : fmt::format(" ({:.0f} min)", time_s / SFromMin(1.0));
  }
  const std::string warmed = WarmedInWords(rows);
  constexpr double kLeastStep_mm = 0.02, kEven = 8;
  const double mean_step_mm = (rows.back()->value_mm - rows.front()->value_mm) /
                              static_cast<double>(steps_mm.size());
  // What moves while nobody looks for minutes may warm or settle.
  constexpr double kApart_s = 120;
  const bool are_far_apart =
      Known(time_s) && time_s > kApart_s * static_cast<double>(steps_mm.size());
  const bool is_staircase = warmed.empty() && !are_far_apart &&
                            std::abs(mean_step_mm) > kLeastStep_mm &&
                            std::abs(mean_step_mm) > kEven * drift.noise_mm;
  const int axis = AxisAlong(*rows.front());
  if (is_staircase) {
    fact.word = "staircase";
    fact.cause = "unknown";
    fact.cause_axis = axis < 0 ? "" : kAxisNames[static_cast<std::size_t>(axis)];
  }
  fact.sentence = fmt::format(
      "The readings at {} {} by {} um over {} ({} of {} steps go that way); about this "
      "drift they scatter by {} um. {}",
      PlaceInWords(*rows.front()),
      drift.change_mm > 0 ? "rise" : "fall",
      TwoDigits(std::abs(UmFromMm(drift.change_mm))),
      over,
      along,
      steps_mm.size(),
      TwoDigits(UmFromMm(drift.noise_mm)),
      is_staircase
          ? fmt::format("Each goes {} mm beyond the one before, alike to {} um: the "
                        "position is lost by so much at each reading (a motor that "
                        "stalls or is switched off in between, a coupling that "
                        "slips), and nothing warms like that",
                        TwoDigits(std::abs(mean_step_mm)),
                        TwoDigits(UmFromMm(drift.noise_mm)))
      : !warmed.empty()        ? "Meanwhile " + warmed
      : KnowsTemperature(rows) ? "No temperature that was logged went along"
                               : "Something settles or warms (probe, frame, bed): no "
                                 "temperature was logged");
  for (const Row* row : rows) fact.rows.push_back(row->row);
  facts->all.push_back(std::move(fact));
}

}  // namespace caltwin
