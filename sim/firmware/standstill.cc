#include "sim/firmware/standstill.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <optional>

#include <Eigen/Dense>

namespace caltwin {
namespace {

constexpr double kCountVariance = 1.0 / 12;  // Of whole pulses.
constexpr double kNoPath_pulses = 1;         // Rms: the counts are no parabola.

// The straight line y = c0 - a u, y the counts less v t, u = t^2 / 2.
struct ParabolaFit {
  double slowing = 0, slowing_sd = 0;  ///< a [pulses/s^2].
  double rms_pulses = 0;
};

std::optional<ParabolaFit> Fit(std::span<const std::int64_t> counts,
                               double tick_s,
                               double speed_pulses_s) {
  if (counts.size() < 3) return std::nullopt;
  const auto number = static_cast<double>(counts.size());
  const auto u_of = [&](std::size_t k) {
    const double t_s = static_cast<double>(k) * tick_s;
    return t_s * t_s / 2;
  };
  const auto y_of = [&](std::size_t k) {
    return static_cast<double>(counts[k] - counts[0]) -
           speed_pulses_s * static_cast<double>(k) * tick_s;
  };
  double u_mean = 0, y_mean = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    u_mean += u_of(k) / number;
    y_mean += y_of(k) / number;
  }
  double uu = 0, uy = 0, yy = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    uu += std::pow(u_of(k) - u_mean, 2);
    uy += (u_of(k) - u_mean) * (y_of(k) - y_mean);
    yy += std::pow(y_of(k) - y_mean, 2);
  }
  const double rms = std::sqrt(std::max(0.0, yy - uy * uy / uu) / (number - 2));
  return ParabolaFit{.slowing = -uy / uu,
                     .slowing_sd = std::sqrt(kCountVariance / uu),
                     .rms_pulses = rms};
}

// Counts from `from` on are within a pulse of the last one.
std::size_t FirstAtRest(std::span<const std::int64_t> counts) {
  std::size_t from = counts.size();
  while (from > 0 && std::abs(counts[from - 1] - counts.back()) <= 1) --from;
  return from;
}

// From `from` on no tick has more counts than a twentieth of those at the told speed.
std::size_t FirstSlow(std::span<const std::int64_t> counts, double told_pulses) {
  constexpr double kSlow = 1.0 / 20;
  const double slow_pulses = std::max(1.0, kSlow * std::abs(told_pulses));
  std::size_t from = counts.size();
  while (from > 1) {
    const auto gone = static_cast<double>(counts[from - 1] - counts[from - 2]);
    if (std::abs(gone) > slow_pulses) break;
    --from;
  }
  return from;
}

// The vertex of the parabola through counts at ticks `from` to `to`, both included,
// where it ends as they do.
std::optional<Standstill> Vertex(std::span<const std::int64_t> counts,
                                 std::size_t from,
                                 std::size_t to,
                                 double tick_s) {
  constexpr double kRounded_pulses = 0.5;  // Rms; 0.29 of whole pulses alone.
  constexpr double kEnds_pulses = 2;       // From where they came to rest.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  for (std::size_t k = from; k <= to; ++k) {
    const auto ticks = static_cast<double>(k - from);
    const auto pulses = static_cast<double>(counts[k] - counts.back());
    const Eigen::Vector3d row(1, ticks, ticks * ticks);
    normal += row * row.transpose();
    right += row * pulses;
    squares += pulses * pulses;
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  const Eigen::Vector3d c = inverse * right;
  const auto number = static_cast<double>(to - from + 1);
  const double rms = std::sqrt(std::max(0.0, squares - c.dot(right)) / (number - 3));
  if (rms > kRounded_pulses || c[2] == 0) return std::nullopt;
  const double ticks = -c[1] / (2 * c[2]);
  const double end_pulses = c[0] + c[1] * ticks / 2;
  if (!(ticks > 0) || std::abs(end_pulses) > kEnds_pulses) return std::nullopt;
  const Eigen::Vector3d slope(0, -1 / (2 * c[2]), -ticks / c[2]);
  const double sd_ticks = std::sqrt(kCountVariance * slope.dot(inverse * slope));
  return Standstill{.at_s = (static_cast<double>(from) + ticks) * tick_s,
                    .sd_s = sd_ticks * tick_s,
                    .is_knocked = true};
}

// By the longest run of counts before their rest that is a parabola.
std::optional<Standstill> AfterAKnock(std::span<const std::int64_t> counts,
                                      std::size_t at_rest,
                                      double tick_s) {
  constexpr std::size_t kFewest = 5;
  constexpr int kRounds = 3;
  std::optional<Standstill> stood;
  std::size_t to = at_rest;
  for (int round = 0; round < kRounds && to < counts.size(); ++round) {
    std::optional<Standstill> vertex;
    for (std::size_t from = 0; !vertex && from + kFewest <= to + 1; ++from) {
      vertex = Vertex(counts, from, to, tick_s);
    }
    if (!vertex || vertex->sd_s > tick_s) break;
    stood = vertex;
    to = static_cast<std::size_t>(stood->at_s / tick_s);
  }
  return stood;
}

// By the parabola of all counts; nullopt where they are none.
std::optional<Standstill> ByOnePath(std::span<const std::int64_t> counts,
                                    std::size_t at_rest,
                                    double tick_s,
                                    double speed_pulses_s) {
  // The last pulse takes longest: those ticks are found by when it stands by the
  // others.
  constexpr int kRounds = 3;
  std::size_t used = at_rest;
  std::optional<Standstill> fitted;
  for (int round = 0; round < kRounds; ++round) {
    const auto fit =
        Fit(counts.first(std::min(used, counts.size())), tick_s, speed_pulses_s);
    if (!fit || fit->rms_pulses > kNoPath_pulses) return std::nullopt;
    const double at_s = speed_pulses_s / fit->slowing;
    const double latest_s = static_cast<double>(counts.size()) * tick_s;
    if (!(at_s > 0) || at_s > latest_s) return std::nullopt;
    fitted = {.at_s = at_s, .sd_s = at_s * std::abs(fit->slowing_sd / fit->slowing)};
    used = static_cast<std::size_t>(at_s / tick_s) + 1;
  }
  return fitted;
}

}  // namespace

Standstill StandstillOf(std::span<const std::int64_t> counts,
                        double tick_s,
                        double speed_pulses_s) {
  if (counts.empty() || speed_pulses_s == 0) return {};
  const std::size_t at_rest = FirstAtRest(counts);
  const std::size_t slow =
      std::min(at_rest, FirstSlow(counts, speed_pulses_s * tick_s));
  const double rests_at_s = static_cast<double>(at_rest) * tick_s;
  const Standstill seen{.at_s = static_cast<double>(slow) * tick_s, .sd_s = tick_s};
  std::optional<Standstill> fitted = ByOnePath(counts, at_rest, tick_s, speed_pulses_s);
  if (!fitted) fitted = AfterAKnock(counts, at_rest, tick_s);
  Standstill stood = fitted.value_or(seen);
  stood.rests_at_s = rests_at_s;
  return stood;
}

}  // namespace caltwin
