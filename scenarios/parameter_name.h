#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One number of the catalog, found by the name that results, studies and reports use:
/// `cause.axis`, followed by `.parameter` where the cause has several.
struct ParameterId {
  int effect = 0;
  std::string axis{};
  std::size_t parameter = 0;
  std::string_view unit{};
};

std::optional<ParameterId> FindParameter(std::string_view name,
                                         const MachineKind* kind = CartesianKind());
/// Every name there is on such a machine, in the catalog's order.
std::vector<std::string> AllParameterNames(const MachineKind* kind = CartesianKind());

/// The built, absolute value of a parameter; nullopt where the name is no parameter's.
std::optional<double> BuiltValueNamed(const Machine& machine,
                                      const std::vector<Injected>& effects,
                                      std::string_view name);

/// What the firmware believes of a parameter: `steps_per_mm.x`, `backlash.x` (of the
/// three axes, or drives) and `probe_pretravel.x` (its probe deflection); nullopt for
/// the rest, which have no setting.
std::optional<double> SettingNamed(const Settings& settings, std::string_view name);
/// The names of all parameters that have a setting.
std::vector<std::string> SettingNames(const MachineKind* kind = CartesianKind());

}  // namespace caltwin
