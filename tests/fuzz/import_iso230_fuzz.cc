#include "tests/fuzz/import_fuzz.h"

// Positioning tests: ecmc data, Renishaw files with a unit given, sheets, rows.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport("iso230-dat", data, size, {.unit = "um"});
}
