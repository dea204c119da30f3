#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/machine/machine.h"
#include "sim/measure/climate.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a row alone does not say: the session it belongs to. Built once from a table,
/// which it borrows nothing of; the `At`s it makes borrow the climate and the row's
/// texts, so both must outlive them.
class Surroundings {
 public:
  explicit Surroundings(const std::vector<Row>& rows);

  /// Fills in what depends on the session: time, homing, temperatures, artefact.
  void Complete(const Row& row, At* at) const;

  /// Whether rows carry times; else their running numbers stand in for seconds.
  bool has_times() const { return has_times_; }
  const Climate& climate() const { return climate_; }
  double TimeOf_s(const Row& row) const;

 private:
  bool has_times_ = false;
  Climate climate_{};
  std::map<std::string, double, std::less<>> homed_at_s_{};
  using Placed = std::pair<std::string, std::string>;  ///< Setup, artefact.
  std::map<Placed, Vec3<double>> artefact_mid_mm_{};
  std::map<std::string, Vec3<double>, std::less<>> circle_mid_mm_{};  ///< By campaign.
};

/// The word before the dot of `feature`: the artefact's id.
std::string_view ArtefactOf(const Row& row);

/// The circumstances of one row under these settings.
///
/// A position or radial row is taken at its commanded pose. A touch is taken where the
/// axes stand at the trigger, q = nominal + (value + R_cfg) n - probe offset, on
/// something that stands on the table. A commanded coordinate the row does not know
/// counts as mid-travel, a sense it does not know as 0: it then stands in the middle of
/// its gap. The feed counts towards the surface, so it is negative for a release
/// (dir . n > 0). Throws InputError where the direction n is missing or no unit vector.
At AtOf(const Row& row, const Machine& machine, const Settings& in_force);

/// Whether a touch row is a release: read while moving away from the surface.
bool IsRelease(const Row& row);

}  // namespace caltwin
