#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// A word misspelt in a kind's list would be an effect that it silently lacks.
TEST(EveryMachineKind, NamesEffectsThatThereAre) {
  auto kinds = AllMachineKinds();
  // Of the same words as others.
  kinds.push_back(CoreXyOnScrewsKind());
  kinds.push_back(GantryOfTwoMotorsKind());
  for (const MachineKind* kind : kinds) {
    for (const KindEffect& one : kind->effects()) {
      EXPECT_TRUE(FindEffect(one.effect)) << kind->name() << ": " << one.effect;
      // Named without an axis: a cartesian machine has it, this one has not.
      if (kind->has_other_effects()) continue;
      EXPECT_FALSE(one.axes.empty()) << kind->name() << ": " << one.effect;
    }
    EXPECT_EQ(MachineKindNamed(kind->name())->name(), kind->name());
  }
}

}  // namespace
}  // namespace caltwin
