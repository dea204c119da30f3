#include "sim/measure/import/check.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/columns.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostFaults = 1000;
constexpr double kLongest_mm = MmFromM(1000.0);

void CheckNumber(std::string_view name,
                 double value,
                 const Bounds& bounds,
                 const Place& place,
                 Faults* faults) {
  const bool is_too_long = name.ends_with("_mm") && std::abs(value) > kLongest_mm;
  const bool is_inside =
      std::isfinite(value) && value >= bounds.min && value <= bounds.max;
  if (!Known(value) || (is_inside && !is_too_long)) return;
  faults->Add(place,
              fmt::format("{} would be {:g}", name, value),
              is_too_long ? "longer than a kilometre: another unit?"
                          : fmt::format("it lies in {} .. {}", bounds.min, bounds.max));
}

void CheckColumn(const Column& column, const Row& row, Faults* faults) {
  if (const auto* component = std::get_if<Component>(&column.member)) {
    const double value = (row.*component->numbers)[component->index];
    CheckNumber(column.name, value, column.bounds, row.place, faults);
  } else if (const auto* number = std::get_if<double Row::*>(&column.member)) {
    CheckNumber(column.name, row.**number, column.bounds, row.place, faults);
  }
}

}  // namespace

void CheckImported(const RowTable& table) {
  Faults faults;
  for (const Row& row : table.rows) {
    if (faults.size() > kMostFaults) break;
    if (row.campaign.empty()) {
      faults.Add(row.place, "campaign is empty", "rows of one campaign share a name");
    }
    if (!std::isfinite(row.value_mm)) {
      faults.Add(row.place, "the value is no finite number");
    }
    CheckNumber("value_mm", row.value_mm, kAnyNumber, row.place, &faults);
    for (const Column& column : AllColumns()) CheckColumn(column, row, &faults);
  }
  faults.ThrowIfAny();
}

}  // namespace caltwin
