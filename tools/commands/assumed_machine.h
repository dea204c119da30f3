#pragma once

#include <string>
#include <vector>

#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A machine nobody described, from the rows themselves: cartesian; each axis travels
/// from the least to the largest commanded position (at least 1 mm), everything else as
/// a machine file's defaults. `notes` gains what was assumed, one sentence an axis.
Machine AssumedMachine(const RowTable& table, std::vector<std::string>* notes);

/// The machine with the leads and full steps that the header's `transmission` states;
/// steps per mm follow where the machine's were as drawn.
Machine WithTransmission(Machine machine, const DataHeader& header);

/// The machine of a file with the steps per mm that all of the header's settings agree
/// on as its settings: the rows were measured under them, whatever it was drawn with.
Machine WithSettingsOf(Machine machine, const DataHeader& header);

/// The machine of nobody's drawing with the steps per mm that all of the header's
/// settings agree on: it was built as it was set.
Machine WithStepsAsSet(Machine machine, const DataHeader& header);

}  // namespace caltwin
