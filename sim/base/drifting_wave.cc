#include "sim/base/drifting_wave.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/base/dense.h"
#include "sim/base/median.h"

namespace caltwin {
namespace {

constexpr double kPeriodsInAPiece = 5;
constexpr double kReach = 1.3;  // A piece's period may be so much off the middle one.
constexpr int kOfAPiece = 5;    // Its unknowns: a line, the wave's two, its period.
constexpr int kOfFixed = 9;     // A line, two parabolas, the period.

Eigen::VectorXd WithoutCubic(const Eigen::VectorXd& at, const Eigen::VectorXd& values) {
  const double middle = (at[0] + at[at.size() - 1]) / 2;
  const Eigen::ArrayXd u = (at.array() - middle) / (at[at.size() - 1] - middle);
  Eigen::MatrixXd columns(at.size(), 4);
  columns << Eigen::VectorXd::Ones(at.size()), u, u.square(), u.cube();
  return values - columns * LeastSquares(columns, values);
}

// From one to the other, each `step` times the one before.
std::vector<double> Geometric(double from, double to, double step) {
  const auto num = static_cast<int>(std::log(to / from) / std::log(step)) + 1;
  std::vector<double> values;
  for (int i = 0; i < num; ++i) values.push_back(from * std::pow(step, i));
  return values;
}

struct WaveFit {
  double left2 = HUGE_VAL, period = 0, size = 0;
};

// Of a line alone.
double LeftOfLine2(const Eigen::VectorXd& at, const Eigen::VectorXd& values) {
  Eigen::MatrixXd columns(at.size(), 2);
  columns << Eigen::VectorXd::Ones(at.size()), at.array() - at.mean();
  return (values - columns * LeastSquares(columns, values)).squaredNorm();
}

// A line and a wave of one period, its size a parabola of the way (and its phase, by
// about a radian).
double LeftOfFixed2(const Eigen::VectorXd& at,
                    const Eigen::VectorXd& values,
                    double period) {
  const Eigen::ArrayXd u = (at.array() - at.mean()) / (at[at.size() - 1] - at[0]);
  const Eigen::ArrayXd phase = 2 * std::numbers::pi / period * (at.array() - at.mean());
  const Eigen::ArrayXd c = phase.cos(), s = phase.sin();
  Eigen::MatrixXd columns(at.size(), kOfFixed - 1);
  columns << Eigen::VectorXd::Ones(at.size()), u, c, s, u * c, u * s, u * u * c,
      u * u * s;
  return (values - columns * LeastSquares(columns, values)).squaredNorm();
}

// A line and a wave of one period.
WaveFit FitWave(const Eigen::VectorXd& at,
                const Eigen::VectorXd& values,
                double period) {
  const Eigen::ArrayXd from_middle = at.array() - at.mean();
  const Eigen::ArrayXd phase = 2 * std::numbers::pi / period * from_middle;
  Eigen::MatrixXd columns(at.size(), 4);
  columns << Eigen::VectorXd::Ones(at.size()), from_middle, phase.cos(), phase.sin();
  const Eigen::VectorXd fit = LeastSquares(columns, values);
  return {.left2 = (values - columns * fit).squaredNorm(),
          .period = period,
          .size = fit.tail(2).norm()};
}

WaveFit BestNear(const Eigen::VectorXd& at,
                 const Eigen::VectorXd& values,
                 double period) {
  constexpr double kStep = 1.03;
  WaveFit best;
  for (const double here : Geometric(period / kReach, period * kReach, kStep)) {
    const WaveFit fit = FitWave(at, values, here);
    if (fit.left2 < best.left2) best = fit;
  }
  return best;
}

struct Pieces {
  std::vector<WaveFit> all{};
  double variance = HUGE_VAL;
  double of_lines = 0;  ///< Variance about a line a piece.
};

// None (infinite variance) where a piece has too few places for a wave of its own.
Pieces InPieces(const Eigen::VectorXd& at,
                const Eigen::VectorXd& values,
                double period) {
  constexpr Eigen::Index kFewest = 15;
  const double span = at[at.size() - 1] - at[0];
  const int num = static_cast<int>(span / (kPeriodsInAPiece * period));
  Pieces pieces;
  double left2 = 0, of_lines2 = 0;
  Eigen::Index first = 0;
  for (int k = 1; k <= num; ++k) {
    const double end = at[0] + span * k / num;
    Eigen::Index last = first;
    while (last < at.size() && (at[last] <= end || k == num)) ++last;
    if (last - first < kFewest) return {};
    const auto own_at = at.segment(first, last - first);
    const auto own_values = values.segment(first, last - first);
    pieces.all.push_back(BestNear(own_at, own_values, period));
    left2 += pieces.all.back().left2;
    of_lines2 += LeftOfLine2(own_at, own_values);
    first = last;
  }
  const auto num_places = static_cast<double>(at.size());
  pieces.variance = left2 / std::max(num_places - kOfAPiece * num, 1.0);
  pieces.of_lines = of_lines2 / std::max(num_places - 2.0 * num, 1.0);
  return pieces;
}

// From three places a wave to three pieces.
Pieces Best(const Eigen::VectorXd& at, const Eigen::VectorXd& values) {
  constexpr double kFewestPieces = 3, kPlacesAWave = 3, kCoarse = 1.12;
  const double span = at[at.size() - 1] - at[0];
  const double shortest = kPlacesAWave * span / static_cast<double>(at.size() - 1);
  const double longest = span / (kFewestPieces * kPeriodsInAPiece);
  if (longest < shortest) return {};
  Pieces best;
  for (const double period : Geometric(shortest, longest, kCoarse)) {
    Pieces pieces = InPieces(at, values, period);
    if (pieces.variance < best.variance) best = std::move(pieces);
  }
  return best;
}

// What two waves of one period each leave, beside a line: two that beat look as if one
// drifted.
double LeftOfTwo2(const Eigen::VectorXd& at,
                  const Eigen::VectorXd& values,
                  const std::vector<double>& periods) {
  constexpr int kRounds = 3;
  const auto wave = [&](double period) {
    const Eigen::ArrayXd phase = 2 * std::numbers::pi / period * at.array();
    Eigen::MatrixXd columns(at.size(), 2);
    columns << phase.cos(), phase.sin();
    return columns;
  };
  const auto without = [](const Eigen::VectorXd& of, const Eigen::MatrixXd& columns) {
    return Eigen::VectorXd(of - columns * LeastSquares(columns, of));
  };
  const auto best_of = [&](const Eigen::VectorXd& of) {
    double least2 = HUGE_VAL, best = periods.front();
    for (const double period : periods) {
      const double left2 = without(of, wave(period)).squaredNorm();
      if (left2 < least2) best = period;
      least2 = std::min(least2, left2);
    }
    return best;
  };
  double one = best_of(values), two = one;
  for (int round = 0; round < kRounds; ++round) {
    two = best_of(without(values, wave(one)));
    one = best_of(without(values, wave(two)));
  }
  Eigen::MatrixXd columns(at.size(), 6);
  columns << wave(one), wave(two), Eigen::VectorXd::Ones(at.size()),
      at.array() - at.mean();
  return without(values, columns).squaredNorm();
}

double MiddleOf(const std::vector<WaveFit>& fits, double WaveFit::*member) {
  std::vector<double> values;
  for (const WaveFit& fit : fits) values.push_back(fit.*member);
  return Median(values);
}

}  // namespace

std::optional<DriftingWave> DriftingWaveOf(const Eigen::VectorXd& at,
                                           const Eigen::VectorXd& values) {
  constexpr Eigen::Index kFewest = 40, kMost = 20000;
  constexpr double kLeastShare = 0.6, kClearly = 2;
  if (at.size() < kFewest || at.size() > kMost) return std::nullopt;
  const Eigen::VectorXd left = WithoutCubic(at, values);
  const Pieces pieces = Best(at, left);
  if (pieces.all.empty() || pieces.of_lines <= 0) return std::nullopt;
  const double share = 1 - pieces.variance / pieces.of_lines;
  if (share < kLeastShare) return std::nullopt;
  const double period = MiddleOf(pieces.all, &WaveFit::period);
  // So fine that the phase at the ends is off by an eighth of a wave at most.
  const double step = 1 + period / (at[at.size() - 1] - at[0]) / 4;
  double fixed2 = HUGE_VAL;
  for (const double here : Geometric(period / kReach, period * kReach, step)) {
    fixed2 = std::min(fixed2, LeftOfFixed2(at, left, here));
  }
  fixed2 = std::min(
      fixed2, LeftOfTwo2(at, left, Geometric(period / kReach, period * kReach, step)));
  const double fixed = fixed2 / static_cast<double>(at.size() - kOfFixed);
  if (fixed < kClearly * pieces.variance) return std::nullopt;
  const auto [shortest, longest] =
      std::ranges::minmax_element(pieces.all, {}, &WaveFit::period);
  const auto [smallest, largest] =
      std::ranges::minmax_element(pieces.all, {}, &WaveFit::size);
  return DriftingWave{.period = period,
                      .least_period = shortest->period,
                      .most_period = longest->period,
                      .size = MiddleOf(pieces.all, &WaveFit::size),
                      .least_size = smallest->size,
                      .most_size = largest->size,
                      .share = share,
                      .share_of_fixed = std::max(0.0, 1 - fixed / pieces.of_lines)};
}

}  // namespace caltwin
