#include "tests/blind/visible.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

namespace blind {
namespace {

double Dot(const Column& a, const Column& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// One column from a formula per reading.
Column Filled(const std::vector<Reading>& readings,
              const std::function<double(const Reading&)>& formula) {
  Column column;
  column.reserve(readings.size());
  for (const Reading& reading : readings) column.push_back(formula(reading));
  return column;
}

/// Touch rows see motion with the opposite sign of gauge rows.
double Sign(const Reading& reading) {
  return reading.stop->kind == Kind::kTouch ? -1 : 1;
}

void AddAxisColumns(std::size_t i,
                    const std::vector<Reading>& readings,
                    std::vector<Column>* columns) {
  columns->push_back(Filled(readings, [i](const Reading& r) {
    return 0.01 * Sign(r) * r.stop->at_mm[i] * r.stop->n[i];
  }));
  columns->push_back(Filled(readings, [i](const Reading& r) {
    return -0.5 * Sign(r) * r.instant.dir[i] * r.stop->n[i];
  }));
  columns->push_back(Filled(readings, [i](const Reading& r) {
    return r.stop->kind == Kind::kTouch ? -r.stop->n[i] * r.stop->n[i] : 0.0;
  }));
}

}  // namespace

std::vector<Column> BaselineColumns(const Plan& plan,
                                    const std::vector<Reading>& readings) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < 3; ++i) AddAxisColumns(i, readings, &columns);
  for (std::size_t i = 0; i < 2; ++i) {
    columns.push_back(Filled(readings, [&, i](const Reading& r) {
      const bool stands =
          r.stop->kind == Kind::kTouch && plan.placements.at(r.stop->setup).on_table;
      if (!stands) return 0.0;
      return 0.01 * (r.stop->at_mm[i] * r.stop->n[2] - r.stop->at_mm[2] * r.stop->n[i]);
    }));
  }
  for (const auto& [setup, placement] : plan.placements) {
    for (std::size_t i = 0; i < 3; ++i) {
      columns.push_back(Filled(readings, [&, i](const Reading& r) {
        return r.stop->setup == setup ? r.stop->n[i] : 0.0;
      }));
    }
    if (placement.turn_sd_rad == 0) continue;
    columns.push_back(Filled(readings, [&](const Reading& r) {
      if (r.stop->setup != setup) return 0.0;
      const Vector3 arm = r.stop->at_mm - placement.center_mm;
      return 0.01 * (arm[0] * r.stop->n[1] - arm[1] * r.stop->n[0]);
    }));
  }
  return columns;
}

Projector::Projector(const std::vector<Column>& columns) {
  for (const Column& column : columns) {
    const double before = std::sqrt(Dot(column, column));
    if (before == 0) continue;
    Column rest = Rest(Rest(column));
    const double after = std::sqrt(Dot(rest, rest));
    if (after < 1e-7 * before) continue;
    for (double& value : rest) value /= after;
    basis_.push_back(std::move(rest));
  }
}

Column Projector::Rest(Column column) const {
  for (const Column& direction : basis_) {
    const double part = Dot(direction, column);
    for (std::size_t i = 0; i < column.size(); ++i) column[i] -= part * direction[i];
  }
  return column;
}

Visible VisibleEffect(const Column& whitened_effect, const Projector& baseline) {
  const Column rest = baseline.Rest(whitened_effect);
  double largest = 0;
  for (const double value : whitened_effect)
    largest = std::max(largest, std::abs(value));
  std::vector<double> sizes;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (std::abs(whitened_effect[i]) > 0.02 * largest)
      sizes.push_back(std::abs(rest[i]));
  }
  if (sizes.empty()) return {};
  const auto place = static_cast<long>(0.95 * static_cast<double>(sizes.size() - 1));
  std::ranges::nth_element(sizes, sizes.begin() + place);
  return {sizes[static_cast<std::size_t>(place)], Dot(rest, rest), largest};
}

}  // namespace blind
