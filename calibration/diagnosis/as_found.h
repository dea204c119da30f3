#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// What the extended machine gets for a finding: its effect, or the table of one that
/// has no formula. None where neither can be built: the scatter of homings, whose every
/// place was read and not what will be drawn.
std::optional<Injected> EffectOf(const Finding& finding);

/// One line of the baseline set to its fitted value in a list of effects: scale,
/// backlash, pre-travel and the bed's slopes. False, and nothing done, for a line that
/// is no effect of the machine (placements, sizes within their certificates) or whose
/// value none can have (a gap below 0, or one that a hanging weight keeps shut).
///
/// A scale s [fraction] on top of `effects` makes 1 / true = 1 / true(effects) + s /
/// set, `set` being the machine's setting.
bool BuildIn(const BaselineLine& line,
             const Machine& machine,
             std::vector<Injected>* effects);

/// The machine as a diagnosis found it.
struct AsFound {
  std::vector<Injected> effects{};  ///< As believed, baseline and findings built in.
  std::set<std::string> built{};    ///< Lines of the baseline that are.
  std::vector<std::size_t> not_built{};  ///< Findings that cannot be.
};
AsFound AsFoundBy(const Observed& observed,
                  const std::vector<BaselineLine>& baseline,
                  const std::vector<Finding>& findings);

}  // namespace caltwin
