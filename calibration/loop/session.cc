#include "calibration/loop/session.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

std::size_t IndexOf(Axis axis) {
  return static_cast<std::size_t>(Index(axis));
}

}  // namespace

std::string NameOf(Setting setting, Axis axis, const DriveMap* drives) {
  switch (setting) {
    case Setting::kStepsPerMm:
      return "steps_per_mm." + DriveName(drives, Index(axis));
    case Setting::kBacklash:
      return "backlash." + DriveName(drives, Index(axis));
    case Setting::kDeflection:
    case Setting::kSingleDeflection:
      return "probe_pretravel." + Name(axis);
  }
  Require(false, "a setting that has a name");
  return "";
}

std::string UnitOf(Setting setting) {
  return setting == Setting::kStepsPerMm ? "1/mm" : "mm";
}

double ValueOf(const Settings& settings, Setting setting, Axis axis) {
  switch (setting) {
    case Setting::kStepsPerMm:
      return settings.steps_per_mm[IndexOf(axis)];
    case Setting::kBacklash:
      return settings.backlash_mm[IndexOf(axis)];
    case Setting::kDeflection:
    case Setting::kSingleDeflection:
      break;
  }
  return settings.probe_deflection_mm[IndexOf(axis)];
}

Session::Session(Bench* bench,
                 std::string procedure,
                 std::string variant,
                 LoopRules rules)
    : bench_(bench),
      procedure_(std::move(procedure)),
      variant_(std::move(variant)),
      rules_(rules),
      controller_(bench->link, bench->machine),
      probing_(bench, &controller_) {
  controller_.set_direction(bench->ledger.direction);
  controller_.set_drive_direction(bench->ledger.drive_direction);
}

std::string Session::NameHere(Setting setting, Axis axis) const {
  return NameOf(setting, axis, bench_->machine.kind->drive_map());
}

double Session::Believed(Setting setting, Axis axis) const {
  return ValueOf(controller_.settings(), setting, axis);
}

Expected<void> Session::Begin() {
  if (const auto prepared = probing_.Prepare(); !prepared) return prepared;
  backup_ = controller_.settings();
  return {};
}

void Session::Tell(const Message& message) {
  result_.messages.push_back(message);
  bench_->say(message.text);
}

void Session::Measured(const std::string& name,
                       double value,
                       const std::string& message) {
  result_.steps.push_back({.procedure = procedure_,
                           .variant = variant_,
                           .name = name,
                           .before = value,
                           .after = value,
                           .message = message});
  bench_->say(message);
}

void Session::Measured(const Proposal& proposal) {
  Measured(NameHere(proposal.setting, proposal.axis),
           Believed(proposal.setting, proposal.axis),
           proposal.why);
  result_.steps.back().iteration = proposal.iteration;
}

Expected<void> Session::Write(Setting setting, Axis axis, double value) {
  switch (setting) {
    case Setting::kStepsPerMm: {
      // The coordinates of an axis hang on its steps/mm, so it is homed again.
      if (const auto raised = probing_.Raise(); !raised) return raised;
      const auto written = controller_.WriteStepsPerMm(axis, value);
      return written ? probing_.Home() : written;
    }
    case Setting::kBacklash:
      return controller_.WriteBacklash(axis, value);
    case Setting::kDeflection:
      return controller_.WriteDeflection(axis, value);
    case Setting::kSingleDeflection:
      break;
  }
  return controller_.WriteSingleDeflection(value);
}

// A change of just the limit is allowed, however it rounds.
constexpr double kRounding = 1e-9;

Expected<std::string> Session::WhyNot(const Proposal& proposal, double before) {
  const double change = proposal.after / before - 1;
  if (proposal.setting == Setting::kStepsPerMm &&
      !(std::abs(change) <= rules_.steps_limit + kRounding)) {
    Tell(Trouble::kUnreasonable, WhyUnlikelySteps(proposal.after / before));
    return fmt::format(
        "{:.4f} would change {:.4f} by {:.1f} %, beyond the limit of "
        "{:.1f} % an "
        "iteration: not applied.",
        proposal.after,
        before,
        PercentFromFraction(change),
        PercentFromFraction(rules_.steps_limit));
  }
  const auto answer =
      bench_->person->Do({.kind = Act::Kind::kConfirm,
                          .text = fmt::format("Set {} from {:.4f} to {:.4f}? {}",
                                              NameHere(proposal.setting, proposal.axis),
                                              before,
                                              proposal.after,
                                              proposal.why),
                          .axis = Letter(proposal.axis)});
  if (answer) return std::string();
  if (answer.error().kind == MachineFault::Kind::kRefused) {
    return std::string("not confirmed: not applied.");
  }
  return tl::unexpected(answer.error());
}

Expected<bool> Session::Apply(const Proposal& proposal) {
  const double before = Believed(proposal.setting, proposal.axis);
  const std::string name = NameHere(proposal.setting, proposal.axis);
  result_.steps.push_back({.procedure = procedure_,
                           .variant = variant_,
                           .iteration = proposal.iteration,
                           .name = name,
                           .before = before,
                           .after = before,
                           .message = proposal.why});
  Step& step = result_.steps.back();
  kept_off_.erase(name);
  if (!rules_.apply) return false;
  if (std::abs(proposal.after - before) < rules_.keep_within_sd * proposal.sd) {
    step.message +=
        fmt::format(" What is set agrees with {:.4f} within its uncertainty: kept.",
                    proposal.after);
    kept_off_[name] = before - proposal.after;
    return true;
  }
  const auto because = WhyNot(proposal, before);
  if (!because) return tl::unexpected(because.error());
  if (!because->empty()) {
    step.verdict = Verdict::kRefused;
    step.message += " " + *because;
    Tell(name + ": " + *because);
    return false;
  }
  const auto written = Write(proposal.setting, proposal.axis, proposal.after);
  if (!written) return tl::unexpected(written.error());
  step.after = Believed(proposal.setting, proposal.axis);
  step.verdict = Verdict::kApplied;
  bench_->say(fmt::format("{}: {:.4f} -> {:.4f}", name, before, step.after));
  return true;
}

Expected<void> Session::RollBack(const Proposal& proposal,
                                 double before,
                                 const std::string& why) {
  const std::string name = NameHere(proposal.setting, proposal.axis);
  Step step{.procedure = procedure_,
            .variant = variant_,
            .iteration = proposal.iteration,
            .name = name,
            .before = Believed(proposal.setting, proposal.axis),
            .verdict = Verdict::kRolledBack,
            .message = "The verification came out worse than before the change."};
  const auto written = Write(proposal.setting, proposal.axis, before);
  if (!written) return written;
  step.after = Believed(proposal.setting, proposal.axis);
  result_.steps.push_back(step);
  Tell(fmt::format("{}: rolled back to {:.4f}.", name, step.after));
  Tell(Trouble::kWorse, why);
  return {};
}

Expected<bool> Session::KeepOrRollBack(const Proposal& proposal,
                                       double before,
                                       const Check& check) {
  constexpr double kSigmas = 3;
  const double after = std::abs(check.error_after);
  const bool worse = after > std::abs(check.error_before) && after > kSigmas * check.sd;
  if (!worse) return true;
  const std::string why = WhyWorse(check.error_before, check.error_after, check.sd);
  // What was kept as it stood has nothing to go back to.
  if (Believed(proposal.setting, proposal.axis) == before) return true;
  if (!rules_.roll_back) {
    Tell(
        fmt::format("{}: the verification came out worse ({:.4f} mm, before {:.4f} mm)"
                    "; the text does not take the change back.",
                    NameHere(proposal.setting, proposal.axis),
                    after,
                    std::abs(check.error_before)));
    if (!why.empty()) Tell(Trouble::kWorse, why);
    return true;
  }
  const auto back = RollBack(proposal, before, why);
  if (!back) return tl::unexpected(back.error());
  return false;
}

void Session::Conclude(const std::string& name,
                       const std::string& unit,
                       const Uncertain& estimate,
                       bool is_setting) {
  Uncertain stated = estimate;
  const auto kept = kept_off_.find(name);
  if (is_setting && estimate.identifiable && kept != kept_off_.end()) {
    stated = WithInput(stated, NotCorrected(kept->second, stated.sd));
  }
  result_.estimates.push_back({.name = name,
                               .unit = unit,
                               .value = stated.value,
                               .sd = stated.sd,
                               .identifiable = stated.identifiable,
                               .is_setting = is_setting,
                               .budget = stated.budget});
  if (stated.identifiable) bench_->ledger.known[name] = stated;
}

void Session::Correlate(std::vector<std::string> names,
                        const Eigen::MatrixXd& covariance) {
  if (names.size() < 2) return;
  result_.correlations.push_back(
      CorrelationsOf(procedure_, std::move(names), covariance));
}

void Session::Explain(const ObservabilityReport& report) {
  for (const Observability& blind : report.blind) {
    result_.observability.push_back(blind);
  }
  for (const std::string& advice : report.advice) {
    const auto& told = result_.messages;
    if (std::ranges::find(told, advice, &Message::text) == told.end()) {
      Tell({advice, Message::Kind::kOpen});
    }
  }
}

void Session::End(Ending ending) {
  result_.ending = ending;
}

ProcedureResult Session::Finish(const Expected<void>& run) {
  if (!run) {
    result_.fault = run.error().reply;
    result_.ending = EndingOfFault(run.error());
    TellWhyProbeFailed(run.error());
    // Whatever position and sense it had is lost.
    if (result_.ending != Ending::kNoTrigger) bench_->ledger.homings = 0;
  }
  bench_->ledger.direction = controller_.direction();
  bench_->ledger.drive_direction = controller_.drive_direction();
  result_.touches = probing_.touches();
  return result_;
}

}  // namespace caltwin
