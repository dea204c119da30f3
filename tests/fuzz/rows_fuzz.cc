#include "sim/measure/rows.h"
#include "tests/fuzz/fuzz.h"

// Measured rows; those that are read are written and read again to the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) {
    const std::string written = RowsText(ParseRows(text, "d.csv"));
    try {
      MustBeSame(RowsText(ParseRows(written, "again.csv")), written);
    } catch (const InputError& error) {
      MustBeSame(error.what(), "what was written is read");
    }
  });
}
