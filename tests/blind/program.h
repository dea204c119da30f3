#pragma once

#include <string>
#include <vector>

namespace blind {

/// Runs a program to its end, its output into `log`; its exit code, or -1.
int RunProgram(const std::vector<std::string>& words, const std::string& log);

}  // namespace blind
