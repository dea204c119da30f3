#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/link/link.h"

namespace caltwin {

/// What a machine's answer means: its lines, or the fault they tell of. A line that
/// begins with "Error:" is a fault: kNoTrigger where a probe move found nothing, kAlarm
/// where the machine is in emergency stop, kRefused otherwise. The fault's `reply` is
/// all lines from the first such one on, joined by newlines.
Expected<std::vector<std::string>> JudgeReply(std::vector<std::string> lines);

}  // namespace caltwin
