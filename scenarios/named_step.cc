#include "scenarios/named_step.h"

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

}  // namespace caltwin
