#include "scenarios/delta_runner.h"

#include <ctime>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "calibration/delta/g33.h"
#include "calibration/delta/joint.h"
#include "scenarios/delta_link.h"
#include "scenarios/delta_procedures.h"
#include "scenarios/delta_record.h"
#include "scenarios/delta_verdict.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "sim/base/input_error.h"
#include "sim/link/transcript.h"
#include "sim/twin/delta_calliper.h"

namespace caltwin {
namespace {

// Of a touch inside the firmware: travel, descent and lift; with E, the probe stowed
// and deployed.
constexpr double kG33Touch_s = 3, kG33Stow_s = 2;

/// A run on its way.
class DeltaRun {
 public:
  DeltaRun(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario),
        delta_(*scenario.delta),
        machine_(scenario.machine.machine),
        options_(options),
        seed_(options.seed.value_or(scenario.seed)),
        built_(DrawDelta(delta_, machine_, seed_, options.sample)),
        fidelity_(options.fidelity.value_or(scenario.fidelity)),
        simulated_(
            machine_, built_, fidelity_ == Fidelity::kPhysics, seed_, options.sample),
        plant_(&simulated_, machine_, built_.scatter_mm, &result_),
        calliper_(built_.build, delta_.calliper_sigma_mm, seed_, options.sample),
        marlin_(machine_.delta->model,
                delta_.settings,
                TowerStepsPerMm(machine_),
                &plant_,
                [this](const GcodeCommand& words, DeltaModel<double>* settings) {
                  return AnswerG33(words, settings);
                }),
        wire_(&marlin_) {
    marlin_.SetMeshRadius_mm(machine_.delta->print_radius_mm);
  }

  RunResult Perform() {
    const std::clock_t start = std::clock();
    result_.scenario = scenario_.file.string();
    result_.about = scenario_.about;
    result_.verbatim = scenario_.verbatim;
    result_.machine = machine_.name;
    result_.fidelity = ToString(fidelity_);
    result_.seed = seed_;
    DeltaTrial trial{.scenario = delta_,
                     .machine = machine_,
                     .built = built_,
                     .before = marlin_.settings()};
    InterruptibleLink link(&wire_);
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&link, options_.transcript);
    }
    TakeAll(recorder ? static_cast<Link*>(recorder.get()) : &link, &trial);
    if (recorder) recorder->Save();
    result_.touches = marlin_.touches() + g33_touches_;
    result_.machine_time_s =
        marlin_.machine_time_s() + kG33Touch_s * g33_touches_ + kG33Stow_s * g33_stows_;
    trial.after = marlin_.settings();
    trial.mesh = marlin_.mesh();
    trial.fit = fit_;
    trial.said_mm = said_mm_;
    trial.has_fault = fault_.has_value();
    trial.was_out_of_reach = was_out_of_reach_;
    JudgeDelta(trial, &result_);
    result_.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return std::move(result_);
  }

 private:
  std::vector<std::string> AnswerG33(const GcodeCommand& words,
                                     DeltaModel<double>* settings) {
    G33Options options{.probe_offset_mm = marlin_.probe_offset_mm(),
                       .variant = g33_variant_};
    options.printable_radius_mm = machine_.delta->print_radius_mm;
    try {
      options = ReadG33(words, options);
    } catch (const InputError& implausible) {
      return {implausible.what()};
    }
    const DeltaProbe probe =
        [this](const DeltaModel<double>& at, double x_mm, double y_mm) {
          ++g33_touches_;
          return plant_.Touch(at, x_mm, y_mm);
        };
    const int before = g33_touches_;
    const DeltaOutcome outcome = CalibrateG33(probe, *settings, options);
    if (options.engages_probe) g33_stows_ += g33_touches_ - before;
    *settings = outcome.settings;
    said_mm_ = outcome.said_mm;
    return outcome.messages;
  }

  void TakeAll(Link* wire, DeltaTrial* trial) {
    const Vec3<double>& offset_mm = delta_.probe_offset_mm;
    if (!offset_mm.isZero(0)) {
      DeltaLinkProbe(wire, machine_.delta->model, marlin_.settings())
          .Say(fmt::format("M851 X{:.2f} Y{:.2f} Z{:.3f}",
                           offset_mm[0],
                           offset_mm[1],
                           offset_mm[2]));
    }
    plant_.SetOffset(marlin_.probe_offset_mm());
    bool is_first = true;
    for (const DeltaStep& step : delta_.calibrate) {
      options_.progress(step.name);
      Take(step, wire);
      if (std::exchange(is_first, false)) trial->after_first = marlin_.settings();
      if (InterruptRequested()) result_.interrupted = true;
      if (was_out_of_reach_ || fault_ || result_.interrupted) break;
    }
  }

  void Take(const DeltaStep& step, Link* wire) {
    RunResult* result = &result_;
    plant_.Begin(step.name);
    fit_.reset();  // What an earlier step knew is no uncertainty of this one's.
    const DeltaModel<double> before = marlin_.settings();
    DeltaLinkProbe probe(wire, machine_.delta->model, before);
    if (step.name == "g33") {
      g33_variant_ = step.variant == "as_published" ? G33Variant::kAsPublished
                                                    : G33Variant::kCorrected;
      if (const auto blind = BlindnessOfG33(step.points)) {
        result->observability.push_back(*blind);
      }
      const auto lines = probe.Say(fmt::format("G33 P{}{}", step.points, step.words));
      result->messages.insert(result->messages.end(), lines.begin(), lines.end());
    } else {
      const DeltaDoors doors{.probe = probe.AsProbe(), .calliper = Calliper()};
      const DeltaOutcome outcome =
          PerformDeltaStep(step, delta_, machine_, doors, before, &fit_);
      if (!probe.fault()) {
        probe.Set(outcome.settings);
        if (outcome.mesh.nodes > 0) probe.Set(outcome.mesh);
        probe.Say("M500");
      }
      said_mm_ = outcome.said_mm;
      result->messages.insert(
          result->messages.end(), outcome.messages.begin(), outcome.messages.end());
    }
    was_out_of_reach_ = probe.was_out_of_reach();
    fault_ = probe.fault();
    if (fault_) result->messages.push_back("the machine said: " + *fault_);
    AddSteps(step, before);
  }

  void AddSteps(const DeltaStep& step, const DeltaModel<double>& before) {
    const DeltaModel<double>& drawn = machine_.delta->model;
    for (const char* name : kDeltaSettingNames) {
      const double was = *DeltaSettingNamed(before, drawn, name);
      const double is = *DeltaSettingNamed(marlin_.settings(), drawn, name);
      if (was == is) continue;
      result_.steps.push_back({.procedure = step.name,
                               .variant = step.variant,
                               .name = name,
                               .before = was,
                               .after = is,
                               .verdict = Verdict::kApplied});
    }
  }

  DeltaCalliper Calliper() {
    return {.rod_mm = [this](int rod) { return calliper_.Rod_mm(rod); },
            .between_mm =
                [this](const Vec3<double>& from_mm, const Vec3<double>& to_mm) {
                  return calliper_.Between_mm(from_mm, to_mm);
                },
            .sigma_mm = delta_.calliper_sigma_mm};
  }

  const Scenario& scenario_;
  const DeltaScenario& delta_;
  const Machine& machine_;
  const RunOptions& options_;
  std::uint64_t seed_;
  BuiltDelta built_;
  Fidelity fidelity_;
  RunResult result_{};
  DeltaTwinPlant simulated_;
  RecordingDeltaPlant plant_;
  SimulatedDeltaCalliper calliper_;
  MarlinDelta marlin_;
  MarlinDeltaWire wire_;
  G33Variant g33_variant_ = G33Variant::kCorrected;
  std::optional<DeltaJointFit> fit_{};
  double said_mm_ = 0;
  int g33_touches_ = 0, g33_stows_ = 0;
  bool was_out_of_reach_ = false;
  std::optional<std::string> fault_{};
};

}  // namespace

RunResult RunDeltaScenario(const Scenario& scenario, const RunOptions& options) {
  return DeltaRun(scenario, options).Perform();
}

}  // namespace caltwin
