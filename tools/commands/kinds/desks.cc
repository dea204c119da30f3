#include "tools/commands/kinds/desks.h"

namespace caltwin {

const DeskKind& DeskKindOf(std::string_view kind) {
  for (const DeskKind* one : {&kDeltaDesk, &kTripleZDesk, &kStationDesk, &kMotorDesk}) {
    if (one->kind == kind) return *one;
  }
  return kGantryDesk;
}

}  // namespace caltwin
