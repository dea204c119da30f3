#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "tools/commands/command.h"

namespace caltwin {

/// What a command answered.
struct Answer {
  int exit_code = 0;
  std::string out{};    ///< What it printed; progress is not kept.
  std::string fault{};  ///< Why it refused its input, "" if it did not.
};

/// The command of `declare`, with `words` after its name.
inline Answer RunCommand(Action (*declare)(CLI::App*),
                         const std::vector<std::string>& words) {
  CLI::App app;
  const Action action = declare(&app);
  app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Answer answer;
  try {
    answer.exit_code = action();
  } catch (const InputError& error) {
    answer = {.exit_code = kBadInput, .fault = error.what()};
  }
  answer.out = ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return answer;
}

/// What it prints of input that it must accept.
inline std::string Printed(Action (*declare)(CLI::App*),
                           const std::vector<std::string>& words) {
  const Answer answer = RunCommand(declare, words);
  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  return answer.out;
}

}  // namespace caltwin
