#include "scenarios/named_step.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {

std::vector<NamedStep> ReadNamedSteps(const YamlValue& list) {
  std::vector<NamedStep> steps;
  for (const YamlValue& item : list.List()) {
    if (item.is_scalar()) {
      steps.push_back(
          {item.Text(),
           YamlValue(
               YAML::Node(), item.file(), item.path(), item.faults(), item.place())});
      continue;
    }
    const auto entries = item.Map().Entries();
    if (entries.size() != 1) {
      item.Fail("is not a mapping of one procedure to its options",
                "write one procedure a line: `- NAME: {axis: x}`");
      continue;
    }
    steps.push_back({entries[0].first, entries[0].second});
  }
  if (list.is_list() && steps.empty() && list.faults()->empty()) {
    list.Fail("is empty", "name at least one procedure; `caltwin explain` lists them");
  }
  return steps;
}

std::vector<NamedStep> ReadNamedSteps(const YamlValue& list,
                                      std::span<const std::string_view> known,
                                      std::string_view what) {
  std::vector<NamedStep> steps;
  for (const NamedStep& step : ReadNamedSteps(list)) {
    if (std::ranges::find(known, step.name) != known.end()) {
      steps.push_back(step);
      continue;
    }
    step.options.Fail(fmt::format("'{}' is no {}", step.name, what),
                      fmt::format("there are {}", fmt::join(known, ", ")));
  }
  return steps;
}

void RefuseNamedStep(const std::string& name,
                     const YamlValue& options,
                     std::span<const std::string_view> known,
                     std::string_view what) {
  options.Fail(fmt::format("'{}' is no {}", name, what),
               fmt::format("there are {}, gcode, external", fmt::join(known, ", ")));
}

}  // namespace caltwin
