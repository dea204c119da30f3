#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/estimate/observability.h"
#include "calibration/estimate/uncertain.h"
#include "calibration/loop/bench.h"
#include "calibration/loop/controller.h"
#include "calibration/loop/outcome.h"
#include "calibration/loop/probing.h"
#include "calibration/loop/remedies.h"
#include "calibration/loop/troubles.h"
#include "sim/machine/drive_map.h"

namespace caltwin {

/// What a firmware can be told.
enum class Setting { kStepsPerMm, kBacklash, kDeflection, kSingleDeflection };

/// "steps_per_mm.x", "backlash.x", "probe_pretravel.x".
std::string NameOf(Setting setting, Axis axis, const DriveMap* drives = nullptr);
std::string UnitOf(Setting setting);
/// What `settings` hold of it.
double ValueOf(const Settings& settings, Setting setting, Axis axis);

/// One change of one setting, before it is made.
struct Proposal {
  Setting setting = Setting::kStepsPerMm;
  Axis axis = Axis::kX;
  double after = 0;
  double sd = 0;  ///< Standard uncertainty of `after`.
  int iteration = 1;
  std::string why{};  ///< One sentence: how the value came about.
};

/// Rules of the loop that a procedure's text or its options decide.
struct LoopRules {
  /// Largest relative change of steps/mm in one iteration (NeXT: 5 %).
  double steps_limit = 0.05;
  /// Whether a verification that comes out worse takes the change back.
  bool roll_back = true;
  bool apply = true;  ///< false: measure and propose only.
  /// What is set already is kept where it lies within so many standard uncertainties of
  /// the proposal, so that repeated runs do not wander with the noise; 0: never.
  double keep_within_sd = 0;
};

/// One procedure at work on a bench: measure, estimate, propose, confirm, apply,
/// verify, keep or roll back. Everything it does becomes part of its result.
class Session {
 public:
  Session(Bench* bench, std::string procedure, std::string variant, LoopRules rules);

  Bench& bench() { return *bench_; }
  Controller& controller() { return controller_; }
  Probing& probing() { return probing_; }
  ProcedureResult& result() { return result_; }
  const LoopRules& rules() const { return rules_; }
  const Settings& believed() const { return controller_.settings(); }
  /// What was believed when this session began.
  const Settings& backup() const { return backup_; }
  double Believed(Setting setting, Axis axis) const;

  /// Homes where needed, reads settings and keeps them as the backup.
  Expected<void> Begin();
  /// For a person, kept with the result; shown at once.
  void Tell(const Message& message);
  /// The trouble and its cause, `why`. As published the guide's list comes first, and
  /// it comes where nothing singles a cause out.
  void Tell(Trouble trouble, const std::string& why);

  /// Limit, confirmation, write; a new steps/mm is followed by homing. Adds a step.
  /// @return whether the setting now is what was proposed, within its uncertainty
  Expected<bool> Apply(const Proposal& proposal);
  /// Back to `before`, with the step and the remedy that belong to it.
  Expected<void> RollBack(const Proposal& proposal,
                          double before,
                          const std::string& why);
  /// Keeps the change where the error after it is not larger than before it, else rolls
  /// it back if the rules say so. Errors are signed alike; `sd` is that of the later
  /// one.
  struct Check {
    double error_before = 0;
    double error_after = 0;
    double sd = 0;
  };
  Expected<bool> KeepOrRollBack(const Proposal& proposal,
                                double before,
                                const Check& check);

  /// A step that changes nothing.
  void Measured(const std::string& name, double value, const std::string& message);
  void Measured(const Proposal& proposal);
  /// The procedure's word on a quantity; remembered in the ledger. A setting that Apply
  /// kept as it was says how far from the estimate it stands (NotCorrected).
  void Conclude(const std::string& name,
                const std::string& unit,
                const Uncertain& estimate,
                bool is_setting = false);
  /// How the errors of what was fitted together go together; fewer than two: nothing.
  void Correlate(std::vector<std::string> names, const Eigen::MatrixXd& covariance);
  /// The verdict of a plan's Jacobian: blind combinations become observability.
  void Explain(const ObservabilityReport& report);
  void End(Ending ending);

  /// The result, a fault among its endings.
  ProcedureResult Finish(const Expected<void>& run);

 private:
  std::string NameHere(Setting setting, Axis axis) const;
  /// Why a change may not be made, by limit or person; empty: it may.
  Expected<std::string> WhyNot(const Proposal& proposal, double before);
  Expected<void> Write(Setting setting, Axis axis, double value);
  bool is_as_published() const { return variant_ == "as_published"; }
  /// Of a fault in a probe move: looks once more where that tells, and says it.
  void TellWhyProbeFailed(const MachineFault& fault);
  /// After homing, the same move.
  FailedProbeMove LookAgain(const ProbeMove& move, FailedProbeMove failed);

  Bench* bench_;
  std::string procedure_;
  std::string variant_;
  LoopRules rules_;
  Controller controller_;
  Probing probing_;
  Settings backup_{};
  std::map<std::string, double> kept_off_{};  ///< Kept settings less their proposals.
  ProcedureResult result_{};
};

/// Runs `body` with the firmware's backlash compensation of `axis` at 0 and sets it
/// back afterwards, also where `body` failed.
template <typename Body>
auto WithoutCompensation(Session* session, Axis axis, Body body) -> decltype(body()) {
  const double kept_mm = session->Believed(Setting::kBacklash, axis);
  const auto off = session->controller().WriteBacklash(axis, 0);
  if (!off) return tl::unexpected(off.error());
  auto result = body();
  const auto on = session->controller().WriteBacklash(axis, kept_mm);
  if (!on && result) return tl::unexpected(on.error());
  return result;
}

}  // namespace caltwin
