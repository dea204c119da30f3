#include "tests/fuzz/import_fuzz.h"

// Configurations and height maps of deltas; the first byte chooses the kind, in
// readable letters, so that seeds are plain files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const caltwin::ImportOptions with_step{.step_mm = 0.0125};
  switch (data[0]) {
    case 'm':
      return caltwin::TryImport("klipper-mesh", data + 1, size - 1);
    case 'h':
      return caltwin::TryImport("rrf-heightmap", data + 1, size - 1);
    case 'g':
      return caltwin::TryImport("rrf-config", data + 1, size - 1);
    case 's':
      return caltwin::TryImport("klipper-delta", data + 1, size - 1, with_step);
    default:
      return caltwin::TryImport("klipper-delta", data, size);
  }
}
