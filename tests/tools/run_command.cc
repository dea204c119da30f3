#include "tests/tools/run_command.h"

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"

namespace caltwin {

Answer RunCommand(Action (*declare)(CLI::App*), const std::vector<std::string>& words) {
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

std::string Printed(Action (*declare)(CLI::App*),
                    const std::vector<std::string>& words) {
  const Answer answer = RunCommand(declare, words);
  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  return answer.out;
}

}  // namespace caltwin
