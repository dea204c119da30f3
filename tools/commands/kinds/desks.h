#pragma once

#include <string_view>

#include "tools/commands/desk.h"

namespace caltwin {

/// The kind of that name (Procedure::kind).
const DeskKind& DeskKindOf(std::string_view kind);

/// Whether a procedure, as --procedure says it, is one of a printer's station, which
/// may stand at any printer.
bool IsOfStation(std::string_view procedure);

/// @name One a kind
extern const DeskKind kGantryDesk, kDeltaDesk, kTripleZDesk, kStationDesk, kMotorDesk;

}  // namespace caltwin
