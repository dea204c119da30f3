#pragma once

#include <span>
#include <string>
#include <string_view>
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

/// The same where only `known` names may stand: others are "no WHAT", and the fault
/// lists them.
std::vector<NamedStep> ReadNamedSteps(const YamlValue& list,
                                      std::span<const std::string_view> known,
                                      std::string_view what);

/// Adds the fault that `name` is "no WHAT", and which there are.
void RefuseNamedStep(const std::string& name,
                     const YamlValue& options,
                     std::span<const std::string_view> known,
                     std::string_view what);

}  // namespace caltwin
