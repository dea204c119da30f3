#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimate/baseline.h"
#include "calibration/estimate/iso230.h"
#include "sim/measure/data_header.h"

namespace caltwin {

/// A sheet with what stands below it.
struct Iso230Report {
  Iso230Sheet sheet{};
  Iso230Budget budget{};
  BaselineFit baseline{};              ///< Offset, scale, reversal.
  double rms_without_reversal_mm = 0;  ///< Of offset and scale alone.
  /// What the header says of the campaign's plan: dwell_s, warm_up, ...
  std::map<std::string, std::string> plan{};
};

/// The report on one choice of a file's rows. `extra` adds what no file knows
/// (alignment, temperature, environment); its device and reading are replaced by those
/// of the campaign's instrument where the header names it, or by the rows' own sigma.
Iso230Report MakeIso230Report(const RowTable& table,
                              const DataHeader& header,
                              const Iso230Choice& choice,
                              Iso230Budget extra = {});

/// The sheet as printed, micrometres.
std::string Iso230Text(const Iso230Report& report);

/// `caltwin iso230 --json` as CONTRACT fixes it, millimetres.
nlohmann::ordered_json Iso230Json(const Iso230Report& report);

}  // namespace caltwin
