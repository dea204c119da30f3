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
    NamedUnit{"F", Quantity::kTemperature, CelsiusFromFahrenheit<double>},
    NamedUnit{"mm/s", Quantity::kFeed, Same},
    NamedUnit{"mm/min", Quantity::kFeed, MmPerSFromMmPerMin<double>},
    NamedUnit{"m/min", Quantity::kFeed, MmPerSFromMPerMin<double>},
    NamedUnit{"m/s", Quantity::kFeed, MmPerSFromMPerS<double>},
    NamedUnit{"inch/min", Quantity::kFeed, MmPerSFromInchPerMin<double>},
    NamedUnit{"N", Quantity::kForce, Same},
    NamedUnit{"kN", Quantity::kForce, NFromKN<double>},
    NamedUnit{"kgf", Quantity::kForce, NFromKgf<double>},
    NamedUnit{"lbf", Quantity::kForce, NFromLbf<double>},
    NamedUnit{"deg", Quantity::kAngle, Same},
    NamedUnit{"rad", Quantity::kAngle, DegFromRad<double>}};

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
                                   Spelling{"°F", "F"},
                                   Spelling{"mm_s", "mm/s"},
                                   Spelling{"mm/sec", "mm/s"},
                                   Spelling{"mm_min", "mm/min"},
                                   Spelling{"mmpm", "mm/min"},
                                   Spelling{"m_min", "m/min"},
                                   Spelling{"m_s", "m/s"},
                                   Spelling{"in/min", "inch/min"},
                                   Spelling{"in_min", "inch/min"},
                                   Spelling{"ipm", "inch/min"},
                                   Spelling{"n", "N"},
                                   Spelling{"kg", "kgf"},
                                   Spelling{"kp", "kgf"},
                                   Spelling{"lb", "lbf"},
                                   Spelling{"lbs", "lbf"},
                                   Spelling{"degree", "deg"},
                                   Spelling{"degrees", "deg"},
                                   Spelling{"°", "deg"},
                                   Spelling{"radian", "rad"},
                                   Spelling{"radians", "rad"}};

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

std::string_view UsualUnit(Quantity quantity) {
  for (const NamedUnit& unit : kUnits) {
    if (unit.quantity == quantity) return unit.name;
  }
  return {};
}

const NamedUnit* UnitInHeading(std::string_view heading, Quantity quantity) {
  while (!heading.empty() &&
         std::string_view(")] \t").find(heading.back()) != std::string_view::npos) {
    heading.remove_suffix(1);
  }
  // A unit may hold such a sign itself: mm/min, mm_s.
  for (std::size_t at = heading.find_first_of("_[(/, "); at != heading.npos;
       at = heading.find_first_of("_[(/, ", at + 1)) {
    const NamedUnit* unit = Lookup(heading.substr(at + 1), quantity);
    if (unit != nullptr) return unit;
  }
  return nullptr;
}

}  // namespace caltwin
