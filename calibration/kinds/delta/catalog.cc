#include "calibration/kinds/delta/catalog.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/delta/calibrate.h"
#include "sim/machine/kinds/delta/drawing.h"

namespace caltwin {
namespace {

constexpr std::string_view kDeltaKind = "delta";

// With the calliper and whatever else somebody put on the bench for deltas.
ProcedureResult DeltaOnBench(const DeltaStep& step, Bench* bench) {
  DeltaBench own;
  if (const auto* const kept = bench->kept.Find<DeltaBench>()) own = *kept;
  own.link = bench->link;
  own.person = bench->person;
  own.machine = bench->machine;
  return CalibrateDelta(step, own);
}

template <std::size_t kIndex>
PreparedProcedure PrepareDelta(YamlMap map, const Machine& drawing) {
  const DeltaStep step = ReadDeltaStep(std::string(kDeltaProcedures[kIndex]), &map);
  const double radius_mm = DeltaOf(drawing).print_radius_mm;
  if (step.reduced_mm >= radius_mm) {
    map.faults()->Add(
        map.place(),
        fmt::format("{} g33's r is {:g} mm, and the bed's radius {:g}: no disc is left "
                    "to touch",
                    map.path(),
                    step.reduced_mm,
                    radius_mm),
        "r is taken off the radius");
  }
  return [step](Bench* bench) {
    return DeltaOnBench(step, bench);
  };
}

constexpr std::array kDeltaCatalog = {
    Procedure{.name = "g33",
              .about =
                  "Marlin's auto calibration of a delta: a grid of touches becomes "
                  "seven heights, those times a normalised inverse matrix become "
                  "corrections, again until the deviation no longer falls. Options: p "
                  "(the grid, 0 to 10), c (precision), f (rounds at least), r (off the"
                  " radius), v (0 to 3: how much it prints), e, o and t (true: as the "
                  "letter alone), variant (as_published, corrected). Its deviation is "
                  "in sample: P2 says 0.000 and may leave 0.09 mm.",
              .has_variants = true,
              .prepare = PrepareDelta<0>,
              .kind = kDeltaKind},
    Procedure{.name = "rrf_least_squares",
              .about =
                  "RepRapFirmware's: two Gauss-Newton rounds over 16 touches. Option: "
                  "factors, 3 endstops, 4 + radius, 6 + angles, 7 + rods, 8 = 6 + bed "
                  "tilt, 9 = 8 + rods. Rods from heights alone are known to a quarter "
                  "of a millimetre. The tilt that 8 and 9 find is told and not "
                  "commanded: Marlin has no setting for it.",
              .prepare = PrepareDelta<1>,
              .kind = kDeltaKind},
    Procedure{.name = "klipper_descent",
              .about =
                  "Klipper's DELTA_CALIBRATE: seven touches, six numbers by coordinate"
                  " descent. One degree of freedom is left, so its own fit says "
                  "little. Option: print (true: twelve distances of a calibration "
                  "print, read by calliper, and the three rods are fitted too: nine "
                  "numbers).",
              .prepare = PrepareDelta<2>,
              .kind = kDeltaKind},
    Procedure{.name = "delta_joint",
              .about =
                  "caltwin's own: all unknowns at once through the exact six-rod "
                  "chain, with priors, uncertainties, the error of points left out. "
                  "Options: points (8 to 400); unknowns (firmware: endstops, radius, "
                  "angles, tilt; machine: 27 and the tilt) or fit (a list of any of "
                  "them, [delta_radius, arm_length]); priors ({arm_length: {value: "
                  "250.4, sd: 0.02}}: what is known beforehand, a setting's as its "
                  "value); rods and print (true: each rod, or twelve distances of a "
                  "calibration print, are read by calliper, which scatters by "
                  "instruments: {calliper: {sigma_um: 20}}); mesh (true: what the "
                  "settings leave is foretold and commanded as a mesh of heights, M421"
                  " and M420). Settings that would change less than twice what the "
                  "readings leave open are kept.",
              .prepare = PrepareDelta<3>,
              .kind = kDeltaKind}};

}  // namespace

std::span<const Procedure> DeltaProcedures() {
  return kDeltaCatalog;
}

}  // namespace caltwin
