#include "tests/fuzz/import_fuzz.h"

// Tables of holes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport("cmm-plate", data, size);
}
