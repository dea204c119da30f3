#include "sim/link/gcode.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) { ParseGcode(text); });
}
