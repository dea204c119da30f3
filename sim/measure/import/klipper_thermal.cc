#include "sim/measure/import/klipper_thermal.h"

#include "sim/measure/import/fields.h"

namespace caltwin {

Imported ReadKlipperThermal(const std::string& text,
                            const std::string& name,
                            const ImportOptions& options) {
  for (const TextLine& line : LinesOf(text)) {
    if (line.text.starts_with('{')) return ReadProbeDrift(text, name, options);
    if (line.text.starts_with("General Stats")) {
      throw InputError({.file = name, .line = line.line, .column = 1},
                       "this is a summary: means and ranges, no readings",
                       "import the log it was made from (probe_accuracy*.json)");
    }
  }
  return ReadFrameLog(text, name, options);
}

}  // namespace caltwin
