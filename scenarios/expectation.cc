#include "scenarios/expectation.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

// Every run has them.
constexpr std::array kFiguresOfAll = {"machine_time_s", "touches"};

std::optional<double> OptionalNumber(YamlMap* map,
                                     const std::string& key,
                                     std::string_view hint) {
  const auto value = map->Optional(key);
  if (!value) return std::nullopt;
  return value->Number(kNotNegative, hint);
}

Near ReadNear(YamlMap map) {
  Near near{.value = map.Number("value"), .within = map.Number("within", kNotNegative)};
  map.NoMoreKeys();
  return near;
}

// An expectation that is none would pass whatever happens.
void RefuseEmpty(const YamlValue& value, const std::string& write) {
  if (!value.is_map() || !value.Map().Entries().empty()) return;
  value.Fail("expects nothing", "write " + write);
}

ParameterExpectation ReadParameter(const std::string& name, const YamlValue& value) {
  ParameterExpectation expected{.name = name};
  YamlMap map = value.Map();
  RefuseEmpty(value, "{truth_within: ...} or {identifiable: ...}");
  expected.truth_within =
      OptionalNumber(&map, "truth_within", "in the parameter's own unit");
  if (const auto flag = map.Optional("identifiable")) {
    expected.identifiable = flag->Flag();
  }
  expected.sd_below = OptionalNumber(&map, "sd_below", "in the parameter's own unit");
  expected.truth_within_sd =
      OptionalNumber(&map, "truth_within_sd", "a number of standard uncertainties");
  if (const auto reads = map.Optional("reads")) {
    expected.reads = ReadNear(reads->Map());
  }
  if (const auto steps = map.Optional("steps")) {
    YamlMap inner = steps->Map();
    if (const auto after = inner.Required("after")) {
      for (const YamlValue& number : after->List()) {
        expected.steps.push_back(number.Number());
      }
      if (after->is_list() && expected.steps.empty()) {
        after->Fail("expects nothing", "write the value after each step");
      }
    }
    expected.steps_within = inner.Number("within", kNotNegative);
    inner.NoMoreKeys();
  }
  map.NoMoreKeys();
  return expected;
}

FigureExpectation ReadFigure(const std::string& name, const YamlValue& value) {
  FigureExpectation expected{.name = name};
  YamlMap bounds = value.Map();
  RefuseEmpty(value, "{above: ...} or {below: ...}");
  if (const auto above = bounds.Optional("above")) {
    expected.within.above = above->Number();
  }
  if (const auto below = bounds.Optional("below")) {
    expected.within.below = below->Number();
  }
  bounds.NoMoreKeys();
  return expected;
}

void RefuseUnknown(const std::string& name,
                   const YamlValue& value,
                   const Expectable& expectable) {
  std::vector<std::string> names = expectable.parameters;
  names.insert(names.end(), expectable.figures.begin(), expectable.figures.end());
  names.insert(names.end(), kFiguresOfAll.begin(), kFiguresOfAll.end());
  names.insert(names.end(), {"outcome", "messages"});
  constexpr std::size_t kFew = 60;
  const std::string nearest = NearestWord(name, names);
  value.Fail(
      "is no parameter that this version knows",
      (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
          (names.size() <= kFew ? fmt::format("it knows {}", fmt::join(names, ", "))
                                : "`caltwin explain` lists them all"));
}

}  // namespace

Expectation ReadExpectation(YamlMap map, const Expectable& expectable) {
  Expectation expected;
  if (const auto outcome = map.Optional("outcome")) {
    expected.outcome = outcome->Word({kOutcomes.begin(), kOutcomes.end()});
  }
  if (const auto messages = map.Optional("messages")) {
    for (const YamlValue& text : messages->List()) {
      expected.messages.push_back(text.Text());
      if (text.is_scalar() && expected.messages.back().empty()) {
        text.Fail("is empty, which every message holds");
      }
    }
    if (messages->is_list() && expected.messages.empty()) {
      messages->Fail("expects nothing", "write words that a message has to hold");
    }
  }
  const auto has = [](const auto& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (const auto& [name, value] : map.Entries()) {
    if (name == "outcome" || name == "messages") continue;
    if (has(expectable.figures, name) || has(kFiguresOfAll, name)) {
      expected.figures.push_back(ReadFigure(name, value));
    } else if (has(expectable.parameters, name)) {
      expected.parameters.push_back(ReadParameter(name, value));
    } else {
      RefuseUnknown(name, value, expectable);
    }
  }
  return expected;
}

}  // namespace caltwin
