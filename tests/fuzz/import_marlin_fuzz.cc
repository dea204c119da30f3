#include "tests/fuzz/import_fuzz.h"

// Terminal logs of Marlin.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport("marlin-log", data, size);
}
