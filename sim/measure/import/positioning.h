#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// One reading of a positioning test.
struct PositionReading {
  int run = 1;       ///< From 1.
  double sense = 0;  ///< 1 or -1; kUnknown where nobody can say.
  double target_mm = 0;
  double value_mm = 0;  ///< Actual minus commanded.
  Place place{};
};

/// The rows of a positioning test of the axis "x", "y" or "z", in the order given.
Imported PositioningRows(const std::vector<PositionReading>& readings,
                         const std::string& axis,
                         const ImportOptions& options);

/// The axis that the option names, else the fallback (with a note that it is assumed).
/// Throws InputError where the option names no axis.
std::string AxisOr(const std::string& fallback,
                   const ImportOptions& options,
                   std::vector<std::string>* assumed);

/// @name The forms, one file each.
Imported ReadEcmcIso230(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);
Imported ReadRenishawRtl(const std::string& text,
                         const std::string& name,
                         const ImportOptions& options);
Imported ReadRunSheet(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options);

}  // namespace caltwin
