#pragma once

#include <string>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"
#include "calibration/procedures/release_backlash.h"

namespace caltwin {

struct AllOptions {
  CommonOptions common{};  ///< `axis` is overridden by each of `axes`.
  std::vector<Axis> axes{kAxes.begin(), kAxes.end()};
  ReleaseOptions release{};
  bool rough = false;           ///< Phase 1 first, by the laser.
  bool backlash_first = false;  ///< Appendix A's order instead of section 2's.
  bool tilt = false;            ///< Plane of the table or a plate too.
  bool verify_at_end = true;
  bool persist = true;
  std::string date{};
  std::string instrument = "dial";  ///< Of phase 5: dial | laser | none.
};

/// NeXT phases 1 to 5 on several axes, then kept in nxt-user-vars.g.
Expected<void> RunAll(Session* session, const AllOptions& options);

extern const Procedure kNextAll;

}  // namespace caltwin
