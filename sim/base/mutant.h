#pragma once

#include <cstdlib>
#include <string_view>

namespace caltwin {

/// A planted mistake, for proving that the tests would notice it: `good`, except in a
/// build with -DCALTWIN_MUTANTS=ON run with CALTWIN_MUTANT=name, where it is `bad`.
/// docs/mutants.md lists them all; tools/mutants.sh runs the tests against each.
template <typename T>
T Mutant([[maybe_unused]] std::string_view name, T good, [[maybe_unused]] T bad) {
#ifdef CALTWIN_MUTANTS
  static const char* const chosen = std::getenv("CALTWIN_MUTANT");
  if (chosen != nullptr && name == chosen) return bad;
#endif
  return good;
}

}  // namespace caltwin
