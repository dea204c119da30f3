#pragma once

#include <string>
#include <vector>

#include "calibration/loop/session.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// Where NeXT keeps what start-up shall run, and what it held before.
inline constexpr const char* kUserVarsFile = "sys/nxt-user-vars.g";
inline constexpr const char* kUserVarsBackup = "sys/nxt-user-vars.bak.g";

/// The lines of nxt-user-vars.g: steps/mm, backlash compensation, deflection per axis,
/// tip radius. `date` is the caller's word ("2026-11-21"), printed as a comment; empty:
/// none. Running them twice makes no error: globals are made only where they do not
/// exist.
std::vector<std::string> UserVarsLines(const Settings& settings,
                                       const std::string& date);

/// Writes the settings in force to the controller, line by line over the wire, and the
/// ones from before this session to the backup; then runs the file twice and reads
/// back what the controller believes. A fault where that differs.
Expected<void> Persist(Session* session, const std::string& date);

}  // namespace caltwin
