#pragma once

#include <stdexcept>

namespace caltwin {

/// A real controller has ended, does not answer or cannot be started; what() says it in
/// words, with what it wrote last.
class HostLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace caltwin
