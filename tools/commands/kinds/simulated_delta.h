#pragma once

#include "scenarios/machine_file.h"
#include "sim/kinds/delta/perform.h"
#include "sim/kinds/delta/twin.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A delta that measures, as `file` and the truth file have it; `options.machine` is
/// not read.
DeltaPerformConfig MakeDeltaConfig(const MachineFile& file, const TwinOptions& options);

/// A delta that G-code drives; likewise. Throws InputError where the truth holds what
/// is no part of it.
DeltaTwinConfig MakeDeltaTwinConfig(const MachineFile& file,
                                    const TwinOptions& options);

/// By how much one reading of the calliper scatters [mm]; 0.02 where nobody stated it.
double CalliperSigma_mm(const Instruments& instruments);

}  // namespace caltwin
