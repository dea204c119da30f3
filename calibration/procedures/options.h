#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/loop/session.h"
#include "sim/base/input_error.h"
#include "sim/base/yaml.h"
#include "sim/machine/artefact.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// LoopRules::keep_within_sd of the corrected procedures.
inline constexpr double kKeepWithinSd = 2;

/// What every procedure that works on one axis can be told.
struct CommonOptions {
  Axis axis = Axis::kX;
  bool as_published = false;
  std::string artefact{};  ///< Its id; empty: the first that fits.
  int repeats = 5;         ///< Touches of one face, or readings of one position.
  int iterations = 1;
  bool verify = true;
  LoopRules rules{};
  Place place{};  ///< Where the options stand, for what only a run can find wrong.

  std::string Variant() const { return as_published ? "as_published" : "corrected"; }
};

/// Reads axis, variant, artefact, repeats, iterations, verify, apply, rollback and
/// steps_limit (a fraction). Left out, `rollback` is what the variant's text says:
/// nothing is taken back as published, everything that came out worse is in the
/// corrected one. `repeats` in `defaults` may be changed by a procedure, `as_published`
/// too.
CommonOptions ReadCommon(YamlMap* map, const CommonOptions& defaults = {});

/// Reads `axis: x` or `axes: [x, y]`; left out: all three.
std::vector<Axis> ReadAxes(YamlMap* map);

/// Reads `dimensions: [25.4, 76.2]`: sizes of the block, ascending, two or more; else a
/// fault and `otherwise`.
std::vector<double> ReadDimensions(YamlMap* map, const std::vector<double>& otherwise);

/// The artefact meant by id, or the first of one of these types. Throws InputError at
/// `place` where the bench has none.
Artefact* FindArtefact(Bench* bench,
                       const std::string& id,
                       const std::vector<ArtefactType>& types,
                       const Place& place);
/// The same, null where there is none and no id was given.
Artefact* SeekArtefact(Bench* bench,
                       const std::string& id,
                       const std::vector<ArtefactType>& types,
                       const Place& place);

}  // namespace caltwin
