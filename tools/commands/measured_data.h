#pragma once

#include <string>
#include <vector>

#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A file of rows as read, with what there is to say about it.
struct Data {
  RowTable table{};
  DataHeader header{};
  std::vector<std::string> notes{};
};

/// Reads rows and their header. Throws InputError, also where there are too few.
Data ReadData(const std::string& file);

/// Throws InputError with what cannot be true; adds the rest to the notes. `machine`:
/// null where it was assumed from the rows.
void JudgeData(const std::string& file, const Machine* machine, Data* data);

/// Notes where rows do not say what the motors of a delta or under a bed did.
void NoteMissingMotors(const Machine& machine, Data* data);

}  // namespace caltwin
