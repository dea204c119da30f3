#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibration/loop/outcome.h"
#include "calibration/procedures/catalog.h"
#include "scenarios/kind_scenario.h"
#include "scenarios/machine_file.h"

namespace caltwin {

/// What `caltwin calibrate` is asked.
struct CalibrateOptions {
  std::string link{};
  std::vector<std::string> procedures{};
  std::string axis{};
  std::string variant{};
  std::string machine{};
  std::string bench{};
  std::vector<std::string> readings{};
  std::string record{};
  std::string transcript{};
  bool apply = false;
  bool yes = false;
};

/// Whether the link is a twin and no machine.
bool IsTwin(const CalibrateOptions& options);

/// The machine that the link's twin or --machine is; none where neither names one.
std::optional<MachineFile> MachineToCalibrate(const CalibrateOptions& options);

/// `calibrate:` of a scenario with these procedures: `next_dual_dimension`, or
/// `next_dual_dimension: {touches: 5}`; --axis and --variant go to each that does not
/// say its own. `known`: those of the machine.
std::string ProceduresText(const CalibrateOptions& options, const Procedures& known);

/// Throws InputError where a procedure is a step that only scenarios have.
void RefuseScenarioSteps(const std::vector<CalibrationStep>& steps,
                         const KindScenario& kind);

/// --reading ID=MILLIMETRES by id. Throws InputError.
std::map<std::string, double> ReadingsOf(const std::vector<std::string>& given);

/// Throws InputError where a file to be written is one that is read.
void RefuseOverwritten(const CalibrateOptions& options);

/// Throws InputError where --apply would ask and nobody is there.
void RequireAnswers(const CalibrateOptions& options);

/// Prints what a procedure found, did and says.
void PrintResult(const std::string& name, const ProcedureResult& result);

/// Whether nothing more is performed: the machine stopped, or a person did, an operator
/// was called, or what was to be applied was refused.
bool StopsTheRest(const CalibrateOptions& options, const ProcedureResult& result);

/// The exit code of all of them together.
int WorstOf(const CalibrateOptions& options,
            const std::vector<ProcedureResult>& results);

}  // namespace caltwin
