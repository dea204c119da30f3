#include "tests/blind/causes.h"

#include <algorithm>

namespace blind {

int AxisIndex(const std::string& axis) {
  return axis == "y" ? 1 : axis == "z" ? 2 : 0;
}

const std::vector<Cause>& LibraryCauses() {
  static const std::vector<Cause> causes = [] {
    std::vector<Cause> all;
    for (const auto& group :
         {DriveCauses(), FrameCauses(), ProbeCauses(), TimeCauses()}) {
      all.insert(all.end(), group.begin(), group.end());
    }
    return all;
  }();
  return causes;
}

const Cause* FindCause(const std::string& name, bool physics) {
  if (physics) {
    const auto found = std::ranges::find(PhysicsCauses(), name, &Cause::name);
    return found == PhysicsCauses().end() ? nullptr : &*found;
  }
  for (const auto* list : {&LibraryCauses(), &OutsideCauses()}) {
    const auto found = std::ranges::find(*list, name, &Cause::name);
    if (found != list->end()) return &*found;
  }
  return nullptr;
}

}  // namespace blind
