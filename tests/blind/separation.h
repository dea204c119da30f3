#pragma once

#include <map>
#include <string>

#include "tests/blind/case.h"
#include "tests/blind/visible.h"

namespace blind {

/// What a defect adds to a row to first order [sigma]: for a touch -(motion . n)
/// - pre-travel + surface, for a gauge motion . n.
Column LinearEffect(const Case& made,
                    const Defect& defect,
                    const std::vector<Reading>& readings);

/// How well other causes of the catalogue imitate `effect` in this plan: the squares
/// left after the baseline and the best of some variants of each, by "cause axis". Only
/// those that leave less than a tenth, or less than 25, are listed. Free-form maps are
/// left out: they imitate everything.
std::map<std::string, double> Separation(const Case& made,
                                         const Circumstances& at,
                                         const Hidden& hidden,
                                         const Column& effect,
                                         const std::vector<Reading>& readings,
                                         const Projector& baseline);

}  // namespace blind
