#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a positioning test of one axis, in any of four forms; value = actual -
/// commanded, one row a reading, in the order measured.
///
/// - ecmc `*_ISO230.dat`: `TGT_DATA[i]=`, `REF_DATA_FWD[i,j]=`, `REF_DATA_BWD[i,j]=`,
/// the
///   reference system's positions (ecmcISO230_2.py of the European Spallation Source).
///   `UNIT` is read; the axis is the letter in TGT_SET_PV (`X-PosCmd`). Within a run
///   forward comes before backward, forward from the first target to the last.
/// - Renishaw `.rtl`: `Targets :` in mm, then `Run Target Data:` with run, target
/// number
///   and deviation. The sense is that in which a run visits the targets. The file does
///   not say the unit of the deviations, so `unit` is asked for.
/// - a sheet: a header line, then a target and the deviations of each run a line. The
///   heading of a run begins with `fwd`, `forward`, `up`, `+` or `bwd`, `backward`,
///   `rev`, `down`, `-`.
/// - measured rows already: taken as they are.
Imported ReadIso230Dat(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin
