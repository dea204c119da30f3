#pragma once

#include <string>
#include <vector>

#include "sim/base/yaml.h"

namespace caltwin {

/// One entry of `calibrate:`: `- next_all`, or `- next_all: {axis: x}`.
struct NamedStep {
  std::string name{};
  YamlValue options;  ///< Null where none are written; stands at the entry then.
};

/// Every entry of a list of one-key maps and bare names; other entries, and an empty
/// list, are faults.
std::vector<NamedStep> ReadNamedSteps(const YamlValue& list);

}  // namespace caltwin
