#pragma once

#include <string>
#include <string_view>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/with_sd.h"

namespace caltwin {

/// A cause on an axis as a machinist calls it: "cyclic error of the X screw".
std::string NameInWords(std::string_view cause, std::string_view axis);

/// What the machine does, with its sizes: "The X screw errs by 5.6 +- 0.2 um once per
/// turn (8.00 mm)". No full stop. A finding without a formula says in what it depends.
std::string WhatItDoes(const Finding& finding);

/// What to do about it (Words::action); empty where nobody knows.
std::string WhatToDo(const Finding& finding);

/// A covariate as a machinist calls it: "position along X", "time"; of rows without
/// times "the order of the rows".
std::string CovariateInWords(std::string_view word, bool is_by_order = false);

/// The unit of a covariate's values, a space before it; empty where it has none.
std::string_view UnitOfCovariate(std::string_view word, bool is_by_order);

/// What to measure next, as a plan has it, and what it would tell. No full stop.
std::string NextInWords(const NextCampaign& next);

}  // namespace caltwin
