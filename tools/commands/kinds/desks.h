#pragma once

#include <string_view>

#include "tools/commands/desk.h"

namespace caltwin {

/// The kind of that name (Procedure::kind).
const DeskKind& DeskKindOf(std::string_view kind);

/// @name One a kind
extern const DeskKind kGantryDesk, kDeltaDesk, kTripleZDesk, kStationDesk, kMotorDesk;

}  // namespace caltwin
