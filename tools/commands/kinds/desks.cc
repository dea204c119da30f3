#include "tools/commands/kinds/desks.h"

#include "calibration/procedures/catalog.h"

namespace caltwin {

bool IsOfStation(std::string_view procedure) {
  const std::string_view name = procedure.substr(0, procedure.find(':'));
  return FindProcedure(name, ProceduresOf(kStationDesk.kind)) != nullptr;
}

const DeskKind& DeskKindOf(std::string_view kind) {
  for (const DeskKind* one : {&kDeltaDesk, &kTripleZDesk, &kStationDesk, &kMotorDesk}) {
    if (one->kind == kind) return *one;
  }
  return kGantryDesk;
}

}  // namespace caltwin
