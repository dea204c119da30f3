#include "sim/base/descriptor.h"

#include <system_error>

#include <unistd.h>

namespace caltwin {

void Descriptor::Set(int number) {
  const int before = std::exchange(number_, number);
  if (before >= 0) close(before);
}

std::string SystemSays(int error) {
  return std::generic_category().message(error);
}

}  // namespace caltwin
