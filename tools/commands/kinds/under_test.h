#pragma once

#include <optional>

#include "tools/commands/closed_loop.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A machine to be diagnosed in a closed loop that measures otherwise than a gantry;
/// nullopt: it does not.
std::optional<MachineUnderTest> UnderTestAsKind(const TwinOptions& options,
                                                const MachineFile& file);

}  // namespace caltwin
