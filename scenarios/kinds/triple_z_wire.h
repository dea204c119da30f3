#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/kinds/triple_z/printer.h"
#include "scenarios/kinds/nobody.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// The wire to a simulated triple-Z printer.
class RrfTripleZWire : public Link {
 public:
  explicit RrfTripleZWire(RrfTripleZ* firmware) : firmware_(firmware) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;

 private:
  RrfTripleZ* firmware_;
};

/// What its firmware starts with, believing the screws to stand there.
RrfTripleZOptions FirmwareOf(const Machine& machine, const Pivots<double>& believed_mm);

/// What calibration knows of it beforehand. `sigma_mm`: of the probe as stated; a touch
/// is counted in whole steps beside.
TripleZBench BenchOf(const Machine& machine, Link* link, double sigma_mm);

/// 95 % quantile of the nozzle's position error over the bed [mm] at 1000 seeded poses
/// of the travel, each come to from below and from above, the mean error taken off: by
/// the closed forms, the screws raised so.
double TripleZPositionP95_mm(const BuiltTripleZ& built, const Vec3<double>& raised_mm);

/// How a bed truly stands, on a lattice of 11 by 11 within 20 mm of the edges.
struct TrueLevel {
  double mean_mm = 0;  ///< Of the magnitudes, against the reference.
  double max_mm = 0;
  double flat_rms_mm = 0;  ///< Its mean left out.
};
TrueLevel TrueLevelOf(const BuiltTripleZ& built,
                      const Vec3<double>& raised_mm,
                      double reference_mm);

}  // namespace caltwin
