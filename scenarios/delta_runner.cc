#include "scenarios/delta_runner.h"

#include <cmath>
#include <ctime>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/delta/joint.h"
#include "scenarios/delta_link.h"
#include "scenarios/delta_procedures.h"
#include "scenarios/delta_twin.h"
#include "scenarios/delta_verdict.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "sim/base/units.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

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
        twin_({.machine = machine_,
               .built = built_,
               .settings = delta_.settings,
               .calliper_sigma_mm = delta_.calliper_sigma_mm,
               .fidelity = options.fidelity.value_or(scenario.fidelity),
               .seed = seed_,
               .sample = options.sample}) {}

  RunResult Perform() {
    const std::clock_t start = std::clock();
    result_.scenario = scenario_.file.string();
    result_.about = scenario_.about;
    result_.verbatim = scenario_.verbatim;
    result_.machine = machine_.name;
    result_.fidelity = ToString(twin_.config().fidelity);
    result_.seed = seed_;
    DeltaTrial trial{.scenario = delta_,
                     .machine = machine_,
                     .built = built_,
                     .before = twin_.marlin().settings()};
    InterruptibleLink link(&twin_.link());
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&link, options_.transcript);
    }
    TakeAll(recorder ? static_cast<Link*>(recorder.get()) : &link, &trial);
    if (recorder) recorder->Save();
    result_.touches = twin_.touches();
    result_.machine_time_s = twin_.machine_time_s();
    result_.header = twin_.record().header;
    result_.rows = twin_.record().rows;
    trial.after = twin_.marlin().settings();
    trial.mesh = twin_.marlin().mesh();
    trial.fit = fit_;
    trial.settings_told = told_.estimates;
    trial.correlations = told_.correlations;
    trial.said_mm = said_mm_;
    trial.tilt_x = told_.tilt_x;
    trial.tilt_y = told_.tilt_y;
    trial.has_fault = fault_.has_value();
    trial.was_out_of_reach = was_out_of_reach_;
    JudgeDelta(trial, &result_);
    result_.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return std::move(result_);
  }

 private:
  void TakeAll(Link* wire, DeltaTrial* trial) {
    const Vec3<double>& offset_mm = delta_.probe_offset_mm;
    if (!offset_mm.isZero(0)) {
      DeltaLinkProbe(wire, machine_.delta->model, twin_.marlin().settings())
          .Say(fmt::format("M851 X{:.2f} Y{:.2f} Z{:.3f}",
                           offset_mm[0],
                           offset_mm[1],
                           offset_mm[2]));
    }
    bool is_first = true;
    for (const DeltaStep& step : delta_.calibrate) {
      options_.progress(step.name);
      Take(step, wire);
      if (std::exchange(is_first, false))
        trial->after_first = twin_.marlin().settings();
      if (InterruptRequested()) result_.interrupted = true;
      if (was_out_of_reach_ || fault_ || result_.interrupted) break;
    }
  }

  void Take(const DeltaStep& step, Link* wire) {
    RunResult* result = &result_;
    twin_.BeginRecord(step.name);
    told_ = {};
    fit_.reset();  // What an earlier step knew is no uncertainty of this one's.
    const DeltaModel<double> before = twin_.marlin().settings();
    DeltaLinkProbe probe(wire, machine_.delta->model, before);
    if (step.name == "g33") {
      twin_.SetG33Variant(VariantOf(step));
      if (const auto blind = BlindnessOfG33(step.points)) {
        result->observability.push_back(*blind);
      }
      const auto lines = probe.Say(fmt::format("G33 P{}{}", step.points, step.words));
      result->messages.insert(result->messages.end(), lines.begin(), lines.end());
      said_mm_ = twin_.said_mm();
    } else {
      const DeltaDoors doors{.probe = probe.AsProbe(), .calliper = twin_.Calliper()};
      const DeltaOutcome outcome =
          PerformDeltaStep(step, delta_, machine_, doors, before, &fit_);
      if (!probe.fault()) {
        probe.Set(outcome.settings);
        if (outcome.mesh.nodes > 0) probe.Set(outcome.mesh);
        probe.Say("M500");
      }
      said_mm_ = outcome.said_mm;
      told_ = {.estimates = outcome.estimates,
               .correlations = outcome.correlations,
               .tilt_x = outcome.tilt_x,
               .tilt_y = outcome.tilt_y};
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
      const double is = *DeltaSettingNamed(twin_.marlin().settings(), drawn, name);
      if (was != is) AddStep(step, name, was, is);
    }
    AddTrims(step, before);
  }

  // What M665 A B C and Z set beside the mean rod and the angles of towers a and b.
  void AddTrims(const DeltaStep& step, const DeltaModel<double>& before) {
    const DeltaModel<double>& after = twin_.marlin().settings();
    constexpr double kRounding = 1e-9;
    const auto add = [&](const std::string& name, double was, double is) {
      if (std::abs(is - was) > kRounding) AddStep(step, name, was, is);
    };
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      add(fmt::format("arm_length.{}", "abc"[i]),
          before.arm_mm[i] - MeanOfTowers(before.arm_mm),
          after.arm_mm[i] - MeanOfTowers(after.arm_mm));
    }
    const double drawn_rad = machine_.delta->model.angle_rad[2];
    add("tower_angle.c",
        DegFromRad(before.angle_rad[2] - drawn_rad),
        DegFromRad(after.angle_rad[2] - drawn_rad));
  }

  void AddStep(const DeltaStep& step, const std::string& name, double was, double is) {
    result_.steps.push_back({.procedure = step.name,
                             .variant = step.variant,
                             .name = name,
                             .before = was,
                             .after = is,
                             .verdict = Verdict::kApplied});
  }

  const Scenario& scenario_;
  const DeltaScenario& delta_;
  const Machine& machine_;
  const RunOptions& options_;
  std::uint64_t seed_;
  BuiltDelta built_;
  DeltaTwin twin_;
  RunResult result_{};
  /// What the last step said of its settings.
  struct Told {
    std::vector<Estimate> estimates{};
    std::vector<Correlations> correlations{};
    double tilt_x = 0, tilt_y = 0;  ///< Of the bed, not commanded.
  };
  Told told_{};
  std::optional<DeltaJointFit> fit_{};
  double said_mm_ = 0;
  bool was_out_of_reach_ = false;
  std::optional<std::string> fault_{};
};

}  // namespace

RunResult RunDeltaScenario(const Scenario& scenario, const RunOptions& options) {
  return DeltaRun(scenario, options).Perform();
}

}  // namespace caltwin
