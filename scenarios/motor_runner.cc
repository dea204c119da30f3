#include "scenarios/motor_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/judging.h"
#include "scenarios/motor_link.h"
#include "sim/base/units.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr double kHolds = 5;  // Standard uncertainties that an estimate may be off.

/// A run on its way.
class MotorRun {
 public:
  MotorRun(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario),
        motor_(*scenario.motor),
        options_(options),
        seed_(options.seed.value_or(scenario.seed)),
        fidelity_(options.fidelity.value_or(scenario.fidelity)),
        rig_(DrawMotorStage(motor_, seed_, options.sample),
             fidelity_ == Fidelity::kPhysics,
             seed_,
             options.sample),
        factory_(MotorFirmwareOf(motor_.drawing)),
        firmware_(std::make_unique<MotorStageFirmware>(factory_, &rig_, &flash_)),
        wire_(firmware_.get()),
        gauge_(&rig_, motor_.laser_sigma_unit.value_or(0), seed_, options.sample) {}

  RunResult Perform() {
    const std::clock_t start = std::clock();
    RunResult result{.scenario = scenario_.file.string(),
                     .about = scenario_.about,
                     .verbatim = scenario_.verbatim,
                     .machine = motor_.drawing.name,
                     .fidelity = ToString(fidelity_),
                     .seed = seed_};
    InterruptibleLink link(&wire_);
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&link, options_.transcript);
    }
    MotorBench bench{.link = recorder ? static_cast<Link*>(recorder.get()) : &link,
                     .drawing = motor_.drawing};
    if (motor_.laser_sigma_unit) {
      bench.gauge = &gauge_;
      bench.gauge_sigma_unit = *motor_.laser_sigma_unit;
    }
    MotorAxes axes(bench);
    SetFields(motor_, scenario_.file, &axes);
    for (std::size_t i = 0; i < motor_.calibrate.size(); ++i) {
      const MotorStep& step = motor_.calibrate[i];
      options_.progress(step.name);
      Take(step, &axes, bench.link, &result);
      if (InterruptRequested()) result.interrupted = true;
      const bool goes_on =
          last_.ending == Ending::kDone || last_.ending == Ending::kConfounded;
      if (goes_on && !result.interrupted) continue;
      for (std::size_t left = i + 1; left < motor_.calibrate.size(); ++left) {
        result.messages.push_back(
            fmt::format("left out after that: {}", motor_.calibrate[left].name));
      }
      break;
    }
    const auto history = bench.link->Send("M504", std::chrono::milliseconds(1000));
    if (history) history_ = history->size();
    if (recorder) recorder->Save();
    result.machine_time_s = earlier_s_ + firmware_->machine_time_s();
    result.lost = last_.ending == Ending::kLinkLost;
    Judge(&result);
    result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return result;
  }

 private:
  static MotorResult SendLines(const MotorStep& step, Link* link) {
    MotorResult done;
    for (const std::string& line : step.lines) {
      const auto answer = link->Send(line, std::chrono::milliseconds(600'000));
      if (answer) {
        for (const std::string& said : *answer) done.result.messages.push_back(said);
        continue;
      }
      done.result.messages.push_back("the machine said: " + answer.error().reply);
      done.result.ending = EndingOfFault(answer.error());
      break;
    }
    return done;
  }

  // The power goes while the lines are obeyed, after so many bytes that they store, and
  // comes back: what the flash holds is in force, and no axis is homed.
  MotorResult CutPower(const MotorStep& step, Link* link) {
    MotorResult done;
    Rng marks(seed_, options_.sample, "power_cut");
    const std::uint64_t before = flash_.bytes_done();
    flash_.CutAfter(step.after_bytes, &marks);
    for (const std::string& line : step.lines) {
      const auto answer = link->Send(line, std::chrono::milliseconds(600'000));
      if (answer) continue;
      const std::string& said = answer.error().reply;
      done.result.messages.push_back("the machine said: " + said);
      const bool is_cut = said.find("the power went") != std::string::npos;
      if (!is_cut) done.result.ending = Ending::kRefused;
      break;
    }
    done.result.messages.push_back(
        fmt::format("the power went, {} bytes of the flash had been written since; it "
                    "is back, and no axis is homed",
                    flash_.bytes_done() - before));
    flash_.PowerUp();
    earlier_s_ += firmware_->machine_time_s();
    MotorStageOptions again = factory_;
    again.clock_unix_s += std::llround(earlier_s_);  // A clock with a battery.
    firmware_ = std::make_unique<MotorStageFirmware>(again, &rig_, &flash_);
    wire_.Connect(firmware_.get());
    return done;
  }

  MotorResult Do(const MotorStep& step, MotorAxes* axes, Link* link) {
    if (step.name == "gcode") return SendLines(step, link);
    if (step.name == "power_cut") return CutPower(step, link);
    return RunMotorProcedure(step.name, step.options, axes);
  }

  void Take(const MotorStep& step, MotorAxes* axes, Link* link, RunResult* result) {
    const MotorResult done = Do(step, axes, link);
    last_ = done.result;
    confounded_ = confounded_ || last_.ending == Ending::kConfounded;
    found_.alerts += done.found.alerts;
    found_.retries += done.found.retries;
    found_.warnings += done.found.warnings;
    found_.safe_modes += done.found.safe_modes;
    found_.positions_lost += done.found.positions_lost;
    const auto keep = [](const auto& from, auto* to) {
      if (from) *to = from;
    };
    keep(done.found.index_edges, &found_.index_edges);
    keep(done.found.wrong_turn_probability, &found_.wrong_turn_probability);
    keep(done.found.skew_s, &found_.skew_s);
    keep(done.found.stop_feasible, &found_.stop_feasible);
    keep(done.found.standstill_s, &found_.standstill_s);
    keep(done.found.stopped_within, &found_.stopped_within);
    AddDone(last_, result);
    result->messages.insert(
        result->messages.end(), last_.messages.begin(), last_.messages.end());
    AddEstimates(result);
  }

  // The built value of an estimate, at once: homes move. nullopt: not known here.
  std::optional<double> BuiltOf(const std::string& name) const {
    const std::size_t dot = name.find('.');
    const auto axis = MotorAxisNamed(name.substr(dot + 1));
    if (!axis) return std::nullopt;
    const BuiltMotorStage& built = rig_.built();
    const MotorAxisDrawing& d = built.motors[*axis].drawing;
    const std::string what = name.substr(0, dot);
    if (what == "backlash") return built.motors[*axis].gap_unit;
    if (what == "home_offset") return TrueHome(*firmware_, rig_, *axis);
    if (what == "travel") {
      return d.max_switch_unit - d.min_switch_unit - TrueHome(*firmware_, rig_, *axis);
    }
    if (what != "start_lead") return std::nullopt;
    double latest_s = 0;
    for (const Estimate& other : last_.estimates) {
      const auto named = MotorAxisNamed(other.name.substr(other.name.find('.') + 1));
      latest_s = std::max(latest_s, built.faults[*named].start_delay_s);
    }
    return latest_s - built.faults[*axis].start_delay_s;
  }

  void AddEstimates(RunResult* result) const {
    for (const Estimate& estimate : last_.estimates) {
      const auto truth = BuiltOf(estimate.name);
      if (!truth) continue;
      std::erase_if(result->parameters, [&](const ParameterResult& had) {
        return had.name == estimate.name;
      });
      result->parameters.push_back({.name = estimate.name,
                                    .unit = estimate.unit,
                                    .injected = *truth,
                                    .recovered = estimate.value,
                                    .error = estimate.value - *truth,
                                    .identifiable = true});
      SetUncertainty(estimate, &result->parameters.back());
    }
  }

  bool MeetValues(RunResult* result) const {
    bool all_met = true;
    for (const DeltaExpectedValue& expected : motor_.values) {
      const auto row =
          std::ranges::find(result->parameters, expected.name, &ParameterResult::name);
      if (row == result->parameters.end()) {
        const bool wants_none = expected.identifiable == false;
        result->checks.push_back({.name = expected.name,
                                  .expected = wants_none ? "no value" : "a value",
                                  .found = "not estimated",
                                  .passed = wants_none});
        all_met = all_met && wants_none;
        continue;
      }
      bool passed = expected.identifiable.value_or(true);
      if (expected.truth_within) {
        row->tolerance = expected.truth_within;
        passed = passed && std::abs(*row->error) <= *expected.truth_within;
      }
      row->passed = passed;
      all_met = all_met && passed;
    }
    return all_met;
  }

  double FigureOf(const std::string& name, const RunResult& result) const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (name == "alerts") return found_.alerts;
    if (name == "retries") return found_.retries;
    if (name == "warnings") return found_.warnings;
    if (name == "safe_modes") return found_.safe_modes;
    if (name == "index_edges") return found_.index_edges.value_or(-1);
    if (name == "wrong_turn_probability") {
      return found_.wrong_turn_probability.value_or(kNone);
    }
    if (name == "skew_ms") return found_.skew_s.value_or(kNone) / SFromMs(1.0);
    if (name == "standstill_ms") {
      return found_.standstill_s.value_or(kNone) / SFromMs(1.0);
    }
    if (name == "stop_feasible") {
      return found_.stop_feasible ? static_cast<double>(*found_.stop_feasible) : kNone;
    }
    if (name == "stopped_within") {
      return found_.stopped_within ? static_cast<double>(*found_.stopped_within)
                                   : kNone;
    }
    if (name == "positions_lost") return found_.positions_lost;
    if (name == "history_entries") return static_cast<double>(history_);
    if (name == "machine_time_s") return result.machine_time_s;
    const std::size_t axis = *MotorAxisNamed(name.substr(name.find('.') + 1));
    if (name.starts_with("home.")) return TrueHome(*firmware_, rig_, axis);
    const AxisCalibration& record = firmware_->record(axis);
    return record.backlash_pulses / record.pulses_per_unit;
  }

  void AddChecks(RunResult* result) const {
    for (const auto& [name, within] : motor_.figures) {
      CheckFigure(name, within, FigureOf(name, *result), result);
    }
    CheckMessages(motor_.messages, result);
  }

  std::string OutcomeOf(bool all_met, const RunResult& result) const {
    if (last_.ending == Ending::kAlarm) return "alarm";
    if (last_.ending == Ending::kNoTrigger) return "no_trigger";
    if (last_.ending == Ending::kRefused) return "refused";
    if (confounded_) return "confounded";
    const bool hold =
        std::ranges::all_of(result.parameters, [](const ParameterResult& row) {
          const double allowed =
              std::max(kHolds * row.sd.value_or(0), row.tolerance.value_or(0));
          return std::abs(*row.error) <= allowed;
        });
    return all_met && hold ? "recovers" : "misses";
  }

  void Judge(RunResult* result) {
    const bool all_met = MeetValues(result);
    AddChecks(result);
    result->outcome = OutcomeOf(all_met, *result);
    CheckOutcome(motor_.outcome, result);
    result->passed =
        !result->interrupted &&
        std::ranges::all_of(result->checks, &CheckResult::passed) &&
        std::ranges::none_of(result->parameters, [](const ParameterResult& row) {
          return row.passed == false;
        });
  }

  const Scenario& scenario_;
  const MotorScenario& motor_;
  const RunOptions& options_;
  std::uint64_t seed_;
  Fidelity fidelity_;
  MotorStageRig rig_;
  Flash flash_{};
  MotorStageOptions factory_;
  std::unique_ptr<MotorStageFirmware> firmware_;
  double earlier_s_ = 0;  // Machine time before the power was last cut.
  MotorStageWire wire_;
  MotorStageGauge gauge_;
  ProcedureResult last_{};
  MotorFindings found_{};
  std::size_t history_ = 0;
  bool confounded_ = false;
};

}  // namespace

RunResult RunMotorScenario(const Scenario& scenario, const RunOptions& options) {
  return MotorRun(scenario, options).Perform();
}

}  // namespace caltwin
