#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/plausible.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/import/import.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A file of rows as read, with what there is to say about it.
struct Data {
  RowTable table{};
  DataHeader header{};
  std::vector<std::string> notes{};
  /// @name Of a file that was imported on the way
  std::string imported_as{};      ///< The kind; empty: it holds rows itself.
  std::string machine_yaml{};     ///< A machine's text, where the file knows one.
  std::vector<FileNote> story{};  ///< What the file says beyond its readings.
  LevellingLog levelling{};
  std::string next_instrument{}, next_sentence{};
  std::string told_kind{};  ///< Imported::told_kind.
  bool has_places = true;   ///< False: positions are indices.
  KnownOfRows known{};
};

/// Reads rows and their header, or imports whatever else the file is: then what was
/// recognised and assumed are notes. Throws InputError. A file may hold no rows where
/// it describes a machine.
Data ReadData(const std::string& file, const ImportOptions& options = {});

/// Throws InputError with what cannot be true; adds the rest to the notes. `machine`:
/// null where it was assumed from the rows.
void JudgeData(const std::string& file, const Machine* machine, Data* data);

/// Notes where rows do not say what the motors of a delta or under a bed did.
void NoteMissingMotors(const Machine& machine, Data* data);

}  // namespace caltwin
