#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <string_view>

#include "sim/base/input_error.h"

namespace caltwin {

/// Gives `read` any bytes. It may complain (InputError, with at least one message, none
/// of them empty); anything else that it throws, a crash, a hang, a leak is a finding.
template <typename Read>
int Try(const std::uint8_t* data, std::size_t size, Read read) {
  try {
    read(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const InputError& error) {
    if (error.faults().empty()) std::abort();
    for (const std::string& fault : error.faults()) {
      if (fault.empty()) std::abort();
    }
  }
  return 0;
}

/// Stops where two texts that must be the same are not.
inline void MustBeSame(std::string_view one, std::string_view other) {
  if (one == other) return;
  std::cerr << "not the same:\n" << one << "\n--- and\n" << other << "\n";
  std::abort();
}

}  // namespace caltwin
