#pragma once

#include <string>

#include "sim/machine/machine.h"
#include "sim/measure/import/import.h"
#include "sim/measure/rows.h"
#include "tests/fuzz/fuzz.h"

namespace caltwin {

/// A machine's text that an import wrote; empty: none.
inline void ReadAgain(const std::string& machine_yaml) {
  if (machine_yaml.empty()) return;
  Faults faults;
  YamlMap map = ReadYamlText(machine_yaml, "machine.yaml", &faults);
  ReadMachine(&map);
  faults.ThrowIfAny();
}

/// Gives the reader of that kind any bytes; a machine and rows that it makes of them
/// are written and read again, the rows to the same.
inline int TryImport(const char* kind,
                     const std::uint8_t* data,
                     std::size_t size,
                     const ImportOptions& options = {}) {
  return Try(data, size, [&](const std::string& text) {
    const Imported imported = ImportText(kind, text, "f", options);
    try {
      ReadAgain(imported.machine_yaml);
      // Settings alone: a machine and no rows, which nobody is given as rows.
      if (imported.table.rows.empty()) return;
      const std::string written = RowsText(imported.table);
      MustBeSame(RowsText(ParseRows(written, "again.csv")), written);
      ParseDataHeader(DataHeaderText(imported.header), "again.yaml");
    } catch (const InputError& error) {
      MustBeSame(error.what(), "what was imported is read");
    }
  });
}

}  // namespace caltwin
