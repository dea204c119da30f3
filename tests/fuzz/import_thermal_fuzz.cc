#include "tests/fuzz/import_fuzz.h"

// Frame expansion logs and probe drift JSON.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport("klipper-thermal", data, size);
}
