#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/link/link.h"

namespace caltwin {

/// The conversation with one client: line numbers, checksums, answers.
class ServeSession {
 public:
  /// `link` is borrowed.
  explicit ServeSession(Link* link) : link_(link) {}

  /// What is printed in answer to a line, `ok` last.
  std::vector<std::string> Answer(std::string_view line);

 private:
  std::vector<std::string> AskToResend(const std::string& why) const;

  Link* link_;
  int last_number_ = 0;
};

}  // namespace caltwin
