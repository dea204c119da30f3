#pragma once

#include "calibration/loop/bench.h"
#include "sim/measure/data_header.h"

namespace caltwin {

/// What explains the rows that a run has recorded: the machine, the settings their ids
/// stand for, instruments and artefacts. Written as DATA.yaml beside DATA.csv.
DataHeader HeaderOfRun(const Bench& bench);

}  // namespace caltwin
