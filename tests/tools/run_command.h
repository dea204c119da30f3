#pragma once

#include <string>
#include <vector>

#include "tools/commands/command.h"

namespace caltwin {

/// What a command answered.
struct Answer {
  int exit_code = 0;
  std::string out{};    ///< What it printed; progress is not kept.
  std::string fault{};  ///< Why it refused its input, "" if it did not.
};

/// The command of `declare`, with `words` after its name.
Answer RunCommand(Action (*declare)(CLI::App*), const std::vector<std::string>& words);

/// What it prints of input that it must accept.
std::string Printed(Action (*declare)(CLI::App*),
                    const std::vector<std::string>& words);

}  // namespace caltwin
