#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"
#include "sim/measure/data_header.h"
#include "sim/measure/plan.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Rows with what explains them.
struct MeasuredSession {
  RowTable table{};
  DataHeader header{};
};

/// A machine that takes readings when asked. It is handed the whole session, of which
/// the first `already_read` rows are its past, and fills in the values of the others.
/// Rows missing from the end of what it returns could not be taken.
using Measurer =
    std::function<RowTable(const MeasuredSession& session, std::size_t already_read)>;

/// A diagnosis between two campaigns.
struct LoopRound {
  int round = 0;           ///< From 1; of rows given at the start 0.
  std::string campaign{};  ///< Kind; empty: the rows given.
  std::map<std::string, std::string> options{};  ///< That differ from the usual.
  double minutes = 0;                            ///< Of machine time.
  std::size_t rows = 0;                          ///< So far.
  DiagnosisVerdict verdict = DiagnosisVerdict::kNone;
  std::vector<std::string> candidates{};  ///< "gantry_sag", each once.
};

struct ClosedLoopOptions {
  int most_campaigns = 6;
  std::uint64_t seed = 1;
  SettingsInForce settings{};  ///< Of the machine, as it tells.
  DiagnoseOptions diagnose{};
  std::function<void(const LoopRound&)> told{};
};

/// How a closed loop ended: all that was measured, and the last diagnosis of it.
struct ClosedLoop {
  MeasuredSession session{};
  std::vector<LoopRound> rounds{};
  Observed observed;
  Diagnosis diagnosis{};
};

/// The session with a planned one after it: ten minutes later, homed and set up anew,
/// so that setups, homings and campaigns are told from earlier ones and time runs on.
/// Rows without times stay so. Values of the planned rows are still to be read.
MeasuredSession Continued(MeasuredSession session, PlannedSession planned, int round);

/// Measures, diagnoses, and measures what the diagnosis asks for, until one cause is
/// left (or none), nothing more can be asked, or `most_campaigns` were measured. With
/// no rows to begin with, the first kind made for such a machine is the first. The
/// diagnosis sees rows, header and the machine as believed, nothing else.
ClosedLoop MeasureUntilSettled(MeasuredSession session,
                               const Machine& machine,
                               const std::vector<Injected>& effects,
                               const Measurer& measure,
                               const ClosedLoopOptions& options);

/// "Round 2: plate_turned_90, 14 min, 180 rows in all: named (gantry_sag)".
std::string RoundText(const LoopRound& round);

/// `"rounds"` of `diagnose --closed-loop --json`.
nlohmann::ordered_json RoundsJson(const std::vector<LoopRound>& rounds);

}  // namespace caltwin
