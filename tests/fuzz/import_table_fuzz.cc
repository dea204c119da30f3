#include <array>

#include "sim/measure/import/recognise.h"
#include "tests/fuzz/import_fuzz.h"

// Tables known by their headings, screw tables, configurations; the first byte chooses
// the kind. Whatever stands in it, a file has a kind.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array<const char*, 5> kKinds = {
      "table", "screw-table", "printer-cfg", "marlin-config", "xml-heightmap"};
  if (size == 0) return 0;
  caltwin::KindOfText(std::string(data + 1, data + size), "f.csv");
  return caltwin::TryImport(kKinds[data[0] % kKinds.size()],
                            data + 1,
                            size - 1,
                            {.unit = "mm", .step_mm = 0.001});
}
