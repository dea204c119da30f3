#include "scenarios/judging.h"

#include <algorithm>

#include <fmt/format.h>

namespace caltwin {

void CheckFigure(const std::string& name,
                 const Within& within,
                 double found,
                 RunResult* result) {
  std::string expected;
  if (within.above) expected += fmt::format("above {:g}", *within.above);
  if (within.below) {
    expected +=
        fmt::format("{}below {:g}", expected.empty() ? "" : ", ", *within.below);
  }
  result->checks.push_back({.name = name,
                            .expected = expected,
                            .found = fmt::format("{:.6g}", found),
                            .passed = (!within.above || found > *within.above) &&
                                      (!within.below || found < *within.below)});
}

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
