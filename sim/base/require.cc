#include "sim/base/require.h"

#include <stdexcept>

#include <fmt/format.h>

namespace caltwin {

void Require(bool condition, std::string_view what, std::source_location where) {
  if (condition) return;
  throw std::logic_error(
      fmt::format("{}:{}: internal error: {}", where.file_name(), where.line(), what));
}

}  // namespace caltwin
