#include "sim/measure/import/unit.h"

#include <array>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

double Same(const double& value) {
  return value;
}

constexpr std::array kUnits = {
    NamedUnit{"mm", Quantity::kLength, Same},
    NamedUnit{"um", Quantity::kLength, MmFromUm<double>},
    NamedUnit{"nm", Quantity::kLength, MmFromNm<double>},
    NamedUnit{"m", Quantity::kLength, MmFromM<double>},
    NamedUnit{"inch", Quantity::kLength, MmFromInch<double>},
    NamedUnit{"thou", Quantity::kLength, MmFromThou<double>},
    NamedUnit{"s", Quantity::kTime, Same},
    NamedUnit{"ms", Quantity::kTime, SFromMs<double>},
    NamedUnit{"min", Quantity::kTime, SFromMin<double>},
    NamedUnit{"h", Quantity::kTime, SFromH<double>},
    NamedUnit{"C", Quantity::kTemperature, Same},
    NamedUnit{"K", Quantity::kTemperature, CelsiusFromKelvin<double>},
    NamedUnit{"F", Quantity::kTemperature, CelsiusFromFahrenheit<double>}};

/// What else people write.
struct Spelling {
  std::string_view written{};
  std::string_view unit{};
};
constexpr std::array kSpellings = {Spelling{"µm", "um"},  // Micro sign.
                                   Spelling{"μm", "um"},  // Greek mu.
                                   Spelling{"micron", "um"},
                                   Spelling{"microns", "um"},
                                   Spelling{"micrometre", "um"},
                                   Spelling{"micrometer", "um"},
                                   Spelling{"in", "inch"},
                                   Spelling{"inches", "inch"},
                                   Spelling{"\"", "inch"},
                                   Spelling{"mil", "thou"},
                                   Spelling{"mils", "thou"},
                                   Spelling{"sec", "s"},
                                   Spelling{"seconds", "s"},
                                   Spelling{"minutes", "min"},
                                   Spelling{"hours", "h"},
                                   Spelling{"degC", "C"},
                                   Spelling{"°C", "C"},
                                   Spelling{"degF", "F"},
                                   Spelling{"°F", "F"}};

const NamedUnit* Lookup(std::string_view name, Quantity quantity) {
  for (const Spelling& spelling : kSpellings) {
    if (spelling.written == name) name = spelling.unit;
  }
  for (const NamedUnit& unit : kUnits) {
    if (unit.name == name && unit.quantity == quantity) return &unit;
  }
  return nullptr;
}

}  // namespace

const NamedUnit& FindUnit(std::string_view name,
                          Quantity quantity,
                          const Place& place) {
  if (const NamedUnit* unit = Lookup(name, quantity)) return *unit;
  std::vector<std::string_view> allowed;
  for (const NamedUnit& unit : kUnits) {
    if (unit.quantity == quantity) allowed.push_back(unit.name);
  }
  throw InputError(place,
                   fmt::format("the unit '{}' is not known here", name),
                   fmt::format("it may be: {}", fmt::join(allowed, ", ")));
}

const NamedUnit* UnitInHeading(std::string_view heading, Quantity quantity) {
  while (!heading.empty() &&
         std::string_view(")] \t").find(heading.back()) != std::string_view::npos) {
    heading.remove_suffix(1);
  }
  const std::size_t before = heading.find_last_of("_[(/, ");
  if (before == std::string_view::npos) return nullptr;
  return Lookup(heading.substr(before + 1), quantity);
}

}  // namespace caltwin
