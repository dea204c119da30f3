#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// What is wrong with repeated touches of one place whose reported height runs away, as
/// a sentence; empty where it does not. It runs away where five or more touches all
/// change in the same sense, by more than 0.1 mm in all: no probe and no warm machine
/// drifts like that within a minute.
std::string ClimbText(const std::vector<double>& heights_mm);

inline constexpr std::string_view kClimbHint =
    "the nozzle was at one place all the time: the Z motor loses steps, or moves "
    "another "
    "way than its steps per mm (step_distance, rotation_distance) say. Correct that, "
    "then measure; nothing else can be told from these readings";

}  // namespace caltwin
