#pragma once

#include <string>

#include "scenarios/study/run.h"

namespace caltwin {

/// "[######......] 12 of 40, 7/s, 4 s left".
std::string ProgressText(const StudyProgress& progress);
/// The same for a program: {"done":12,"all":40}.
std::string ProgressJson(const StudyProgress& progress);

}  // namespace caltwin
