#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "scenarios/machine_file.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// What readings are taken with, as PerformConfig has it.
struct ToPerform {
  DataHeader header{};
  std::size_t already_read = 0;  ///< Rows at the beginning; chance goes on from there.
  std::function<bool()> interrupted{};
};

/// A machine that takes readings, built as its file and a truth file say.
struct Performer {
  Machine machine{};  ///< As drawn, with the settings that its firmware has.
  std::function<RowTable(const ToPerform& with, std::vector<Row> planned)> perform{};
};

/// `options`: truth, fidelity and seed. Throws InputError.
Performer PerformerOf(const MachineFile& file, const TwinOptions& options);

}  // namespace caltwin
