#pragma once

#include <string>

#include "sim/base/text_file.h"
#include "sim/measure/import/import.h"
#include "sim/measure/rows.h"

namespace caltwin {

/// The text of a file in tests/data.
inline std::string TestData(const std::string& name) {
  return ReadTextFile(std::string(CALTWIN_SOURCE_DIR) + "/tests/data/" + name,
                      1'000'000);
}

/// What the reader of that kind complains of, or empty.
inline std::string ImportFault(const std::string& kind,
                               const std::string& text,
                               const ImportOptions& options = {}) {
  try {
    ImportText(kind, text, "f", options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// The rows of an import as they are written and read again: what a person gets.
inline RowTable RowsOf(const std::string& kind,
                       const std::string& text,
                       const ImportOptions& options = {}) {
  const Imported imported = ImportText(kind, text, "f", options);
  ParseDataHeader(DataHeaderText(imported.header), "f.yaml");
  return ParseRows(RowsText(imported.table), "f.csv");
}

}  // namespace caltwin
