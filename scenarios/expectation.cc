#include "scenarios/expectation.h"

#include <fmt/format.h>

#include "scenarios/parameter_name.h"

namespace caltwin {
namespace {

constexpr const char* kPositionError = "position_error_mm.p95";

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

ParameterExpectation ReadParameter(const std::string& name, const YamlValue& value) {
  ParameterExpectation expected{.name = name};
  if (!FindParameter(name)) {
    const std::string nearest = NearestWord(name, AllParameterNames());
    value.Fail("is no parameter that this version knows",
               (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                   "`caltwin explain` lists them all");
  }
  YamlMap map = value.Map();
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
    }
    expected.steps_within = inner.Number("within", kNotNegative);
    inner.NoMoreKeys();
  }
  map.NoMoreKeys();
  return expected;
}

}  // namespace

Expectation ReadExpectation(YamlMap map) {
  Expectation expected;
  if (const auto outcome = map.Optional("outcome")) {
    expected.outcome = outcome->Word({kOutcomes.begin(), kOutcomes.end()});
  }
  if (const auto error = map.Optional(kPositionError)) {
    YamlMap inner = error->Map();
    expected.position_error_below_mm = inner.Number("below", kPositive, "in mm");
    inner.NoMoreKeys();
  }
  if (const auto messages = map.Optional("messages")) {
    for (const YamlValue& text : messages->List()) {
      expected.messages.push_back(text.Text());
    }
  }
  for (const auto& [name, value] : map.Entries()) {
    if (name == "outcome" || name == kPositionError || name == "messages") continue;
    expected.parameters.push_back(ReadParameter(name, value));
  }
  return expected;
}

}  // namespace caltwin
