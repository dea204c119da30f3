#include "scenarios/judging.h"

#include <algorithm>

namespace caltwin {

void CheckMessages(const std::vector<std::string>& texts, RunResult* result) {
  for (const std::string& text : texts) {
    const bool is_there = std::ranges::any_of(
        result->messages,
        [&](const std::string& line) { return line.find(text) != std::string::npos; });
    result->checks.push_back({.name = "message",
                              .expected = text,
                              .found = is_there ? "said" : "not said",
                              .passed = is_there});
  }
}

void CheckOutcome(const std::string& expected, RunResult* result) {
  result->checks.insert(result->checks.begin(),
                        {.name = "outcome",
                         .expected = expected,
                         .found = result->outcome,
                         .passed = result->outcome == expected});
}

}  // namespace caltwin
