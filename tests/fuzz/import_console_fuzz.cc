#include "tests/fuzz/import_fuzz.h"

// Terminal logs of any firmware.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport("console-log", data, size);
}
