#include "tests/fuzz/import_fuzz.h"

// Spreadsheets under a map that reads times, senses and texts.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::TryImport(
      "csv",
      data,
      size,
      {.map = {"cmd_x_mm=1[mm],value_mm=2[um],t_s=3[clock],dir_x:=order"}});
}
