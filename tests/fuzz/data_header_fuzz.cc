#include "sim/measure/data_header.h"
#include "tests/fuzz/fuzz.h"

// The header of a data file; one that is read is written and read again to the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) {
    const std::string written = DataHeaderText(ParseDataHeader(text, "d.yaml"));
    try {
      MustBeSame(DataHeaderText(ParseDataHeader(written, "again.yaml")), written);
    } catch (const InputError& error) {
      MustBeSame(error.what(), "what was written is read");
    }
  });
}
