#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/effects/effect.h"

namespace caltwin {

/// A table over one or two covariates, as the values of an effect hold it:
///
///   {values .., knots of the first .., knots of the second .., number of first knots}
///
/// values by the first covariate slowest, knots ascending. One value alone is the same
/// everywhere; none is nothing.
std::vector<double> FlatMap(const std::vector<double>& values,
                            const std::vector<std::vector<double>>& knots);

/// Values and knots of a table with `num_covariates` of them, taken apart again.
struct MapTable {
  std::vector<double> values{};
  std::vector<std::vector<double>> knots{};
};
MapTable TableOf(std::span<const double> flat, std::size_t num_covariates);

/// Channel and covariates as one axis word: "z{x,temp}".
std::string MapAxis(std::string_view channel, std::span<const std::string> covariates);

/// The axis word taken apart.
struct MapWords {
  std::string_view channel{};
  std::array<std::string_view, 2> covariates{};
  std::size_t num_covariates = 0;
};
MapWords WordsOf(std::string_view axis);

/// What a reading knows of a covariate, in CONTRACT's words: x y z (commanded) t temp
/// dir_x dir_y dir_z since_rev feed load theta. `temp` is T - T0 of the sensor that
/// moves most, `since_rev` that of the axis the value is measured along, theta the
/// direction of the normal seen from above [rad]. kUnknown where it does not know it.
double CovariateAt(const At& at, std::string_view word);

/// Whether CovariateAt knows the word at all.
bool IsCovariate(std::string_view word);

/// Where a value lies between two of a list of knots, which may carry derivatives.
template <typename T>
struct Between {
  std::size_t first = 0, second = 0;
  T share = T(0);  ///< Of the second.
};

/// Constant outside the knots.
template <typename T>
Between<T> Locate(std::span<const T> knots, double value) {
  const std::size_t last = knots.size() - 1;
  if (!(knots[0] < value)) return {0, 0, T(0)};
  if (!(knots[last] > value)) return {last, last, T(0)};
  std::size_t next = 1;
  while (!(knots[next] > value)) ++next;
  return {next - 1, next, (value - knots[next - 1]) / (knots[next] - knots[next - 1])};
}

/// Linear between the knots, constant outside them, 0 where a covariate is not known.
template <typename T>
T MapValue(std::span<const T> flat, const MapWords& words, const At& at) {
  if (flat.empty()) return T(0);
  if (flat.size() == 1) return flat[0];
  if (words.num_covariates == 0) return T(0);
  double first_knots = 0;
  if constexpr (requires { flat.back().a; }) {
    first_knots = flat.back().a;
  } else {
    first_knots = flat.back();
  }
  const auto rows = static_cast<std::size_t>(first_knots);
  const std::size_t columns =
      words.num_covariates == 1 ? 1 : (flat.size() - 1 - rows) / (rows + 1);
  const double u = CovariateAt(at, words.covariates[0]);
  if (!std::isfinite(u)) return T(0);
  const std::size_t cells = rows * columns;
  const Between<T> row = Locate(flat.subspan(cells, rows), u);
  Between<T> column;
  if (words.num_covariates == 2) {
    const double v = CovariateAt(at, words.covariates[1]);
    if (!std::isfinite(v)) return T(0);
    column = Locate(flat.subspan(cells + rows, columns), v);
  }
  const auto along = [&](std::size_t r) {
    const T& near = flat[r * columns + column.first];
    return near + column.share * (flat[r * columns + column.second] - near);
  };
  const T near = along(row.first);
  return near + row.share * (along(row.second) - near);
}

}  // namespace caltwin
