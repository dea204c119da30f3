#pragma once

#include <string>
#include <string_view>

#include "calibration/loop/bench.h"
#include "calibration/loop/outcome.h"
#include "scenarios/child_process.h"
#include "sim/base/yaml.h"

namespace caltwin {

/// Somebody else's algorithm as a step of `calibrate`: `external: {command: [python3,
/// my_calibration.py], timeout_s: 600}`. It runs in the scenario file's folder, so that
/// paths in it are relative to that file.
struct ExternalCommand {
  ChildCommand child{};
};

ExternalCommand ReadExternal(YamlMap options);

/// Answers the lines of an external algorithm, as docs/external.md has them:
///
/// - `M118 GAUGE id` -> `gauge id value_mm`, at standstill
/// - `M118 ZERO id`
/// - `M118 OPERATOR text`: words that name the block, one of its sizes and an axis turn
///   it ("turn block 50.8 along x"); "fit disc" and "fit ball" change the stylus;
///   anything else is asked of the person as it stands
/// - `M118 ESTIMATE name value sd`
/// - anything else goes to the machine
///
/// Every answer ends with `ok`; a fault is a line `Error: ...` before it.
class ExternalProtocol {
 public:
  explicit ExternalProtocol(Bench* bench) : bench_(bench) {}

  std::string Answer(std::string_view line);
  const std::vector<Estimate>& estimates() const { return estimates_; }
  /// How the last fault of the machine would end a run; kDone where there was none.
  Ending ending() const { return ending_; }
  const std::string& fault() const { return fault_; }

 private:
  std::string Fault(const MachineFault& fault);
  std::string ReadGauge(const std::string& id);
  std::string Ask(const std::string& text);
  std::string TakeEstimate(const std::vector<std::string>& words);
  std::string SendToMachine(std::string_view line);

  Bench* bench_;
  std::vector<Estimate> estimates_{};
  Ending ending_ = Ending::kDone;
  std::string fault_{};
};

struct ExternalRun {
  ProcedureResult result{};
  ChildEnd end{};
  bool passed() const { return end.how == ChildEnd::How::kExited && end.code == 0; }
  /// A process lost, as opposed to one that ended with a verdict of its own.
  bool lost() const {
    return end.how != ChildEnd::How::kExited && end.how != ChildEnd::How::kInterrupted;
  }
};

ExternalRun RunExternal(const ExternalCommand& command, Bench* bench);

}  // namespace caltwin
