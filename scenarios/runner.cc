#include "scenarios/runner.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>

#include <fmt/format.h>

#include "calibration/loop/bench.h"
#include "scenarios/delta_runner.h"
#include "scenarios/external.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/motor_runner.h"
#include "scenarios/parameter_name.h"
#include "scenarios/position_error.h"
#include "scenarios/record.h"
#include "scenarios/triple_z_runner.h"
#include "scenarios/verdict.h"
#include "scenarios/z_offset_runner.h"
#include "sim/base/rng.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr int kPoses = 1000;

// After these the machine is not where the next procedure would expect it.
bool StopsTheRun(Ending ending) {
  switch (ending) {
    case Ending::kNoTrigger:
    case Ending::kCollision:
    case Ending::kAlarm:
    case Ending::kLinkLost:
      return true;
    case Ending::kDone:
    case Ending::kReadsZero:
    case Ending::kConfounded:
    case Ending::kRefused:
      break;
  }
  return false;
}

// What a program that reports no steps of its own has changed.
std::vector<Step> ChangesBetween(const Settings& before, const Settings& after) {
  std::vector<Step> steps;
  for (const std::string& name : SettingNames()) {
    const double was = *SettingNamed(before, name);
    const double is = *SettingNamed(after, name);
    if (was == is) continue;
    steps.push_back({.procedure = "external",
                     .name = name,
                     .before = was,
                     .after = is,
                     .verdict = Verdict::kApplied,
                     .message = "set by the external program"});
  }
  return steps;
}

ProcedureResult PerformExternal(const ExternalCommand& command,
                                Twin* twin,
                                Bench* bench,
                                RunResult* result) {
  const Settings before = twin->settings();
  const ExternalRun run = RunExternal(command, bench);
  ProcedureResult performed = run.result;
  performed.steps = ChangesBetween(before, twin->settings());
  for (const Estimate& estimate : performed.estimates) {
    if (SettingNamed(before, estimate.name)) continue;  // Told by its change.
    performed.steps.push_back({.procedure = "external",
                               .name = estimate.name,
                               .before = estimate.value,
                               .after = estimate.value,
                               .verdict = Verdict::kMeasured,
                               .message = "handed in by the external program"});
  }
  result->lost = result->lost || run.lost();
  result->checks.push_back({.name = "external",
                            .expected = "exited with 0",
                            .found = ToString(run.end),
                            .passed = run.passed()});
  return performed;
}

std::vector<ProcedureResult> PerformAll(const Scenario& scenario,
                                        const RunOptions& options,
                                        Twin* twin,
                                        Bench* bench,
                                        RunResult* result) {
  std::vector<ProcedureResult> results;
  for (std::size_t i = 0; i < scenario.calibrate.size(); ++i) {
    const CalibrationStep& step = scenario.calibrate[i];
    options.progress(
        fmt::format("{}/{} {}", i + 1, scenario.calibrate.size(), step.name));
    results.push_back(step.external
                          ? PerformExternal(*step.external, twin, bench, result)
                          : step.procedure(bench));
    const ProcedureResult& last = results.back();
    if (InterruptRequested()) {
      result->interrupted = true;
      break;
    }
    if (last.ending == Ending::kLinkLost) result->lost = true;
    if (StopsTheRun(last.ending) || (step.external && !result->checks.back().passed)) {
      if (i + 1 < scenario.calibrate.size()) {
        result->messages.push_back(fmt::format("{} of {} steps were not reached",
                                               scenario.calibrate.size() - i - 1,
                                               scenario.calibrate.size()));
      }
      break;
    }
  }
  return results;
}

// Procedures repeat what they said before measuring and what the one before them said:
// once is enough.
void AddOnce(const std::string& message, std::vector<std::string>* messages) {
  if (std::ranges::find(*messages, message) == messages->end()) {
    messages->push_back(message);
  }
}

void Collect(const std::vector<ProcedureResult>& results, RunResult* result) {
  for (const ProcedureResult& part : results) {
    AddDone(part, result);
    for (const std::string& message : part.messages) {
      AddOnce(message, &result->messages);
    }
    if (!part.fault.empty())
      AddOnce("the machine said: " + part.fault, &result->messages);
  }
}

void Judge(const Scenario& scenario, const Trial& trial, RunResult* result) {
  result->parameters = MakeTable(trial, scenario.expect);
  result->outcome = JudgeOutcome(trial, result->parameters);
  // What a plan could not tell is settled where a later reading has told it.
  std::erase_if(result->observability, [&](const Observability& blind) {
    return std::ranges::all_of(blind.blind_direction, [&](const auto& part) {
      const auto row =
          std::ranges::find(result->parameters, part.first, &ParameterResult::name);
      return row == result->parameters.end() || row->identifiable;
    });
  });
  const auto checks =
      MakeChecks(trial, scenario.expect, result->parameters, result->outcome);
  result->checks.insert(result->checks.begin(), checks.begin(), checks.end());
  const bool all_checks = std::ranges::all_of(result->checks, &CheckResult::passed);
  const bool all_parameters = std::ranges::none_of(
      result->parameters,
      [](const ParameterResult& row) { return row.passed == false; });
  result->passed =
      all_checks && all_parameters && !result->lost && !result->interrupted;
}

}  // namespace

TwinConfig MakeTwinConfig(const Scenario& scenario, const RunOptions& options) {
  const std::uint64_t seed = options.seed.value_or(scenario.seed);
  return {
      .machine =
          DrawBuilt(scenario.machine.machine, scenario.varied, seed, options.sample),
      .effects = DrawEffects(scenario.effects, seed, options.sample),
      .settings = DrawSettings(
          scenario.machine.machine.settings, scenario.settings, seed, options.sample),
      .artefacts =
          DrawArtefacts(scenario.artefacts, scenario.varied, seed, options.sample),
      .instruments =
          DrawInstruments(scenario.instruments, scenario.varied, seed, options.sample),
      .fidelity = options.fidelity.value_or(scenario.fidelity),
      .firmware = scenario.firmware,
      .seed = seed,
      .sample = options.sample};
}

double PositionErrorP95_mm(const Twin& twin) {
  // The poses belong to the machine's travel and not to the run's chance, so that any
  // two runs are compared at the same places.
  Rng rng(1, 0, "position_error_mm");
  std::vector<Vec3<double>> errors_mm;
  for (int pose = 0; pose < kPoses; ++pose) {
    Vec3<double> q_mm;
    for (const Axis axis : kAxes) {
      const AxisDrawing& drawing = twin.config().machine.axis(axis);
      q_mm[Index(axis)] = drawing.min_mm + drawing.travel_mm() * rng.Uniform();
    }
    for (const double sense : {1.0, -1.0}) {
      errors_mm.push_back(twin.PositionError_mm(q_mm, Vec3<double>::Constant(sense)));
    }
  }
  return P95AboutMean_mm(errors_mm);
}

RunResult RunScenario(const Scenario& scenario, const RunOptions& options) {
  if (scenario.delta) return RunDeltaScenario(scenario, options);
  if (scenario.triple_z) return RunTripleZScenario(scenario, options);
  if (scenario.motor) return RunMotorScenario(scenario, options);
  if (scenario.z_offset) return RunZOffsetScenario(scenario, options);
  const std::clock_t start = std::clock();
  Twin twin(MakeTwinConfig(scenario, options));
  const TwinConfig& config = twin.config();
  RunResult result{.scenario = scenario.file.string(),
                   .about = scenario.about,
                   .verbatim = scenario.verbatim,
                   .machine = config.machine.name,
                   .fidelity = ToString(config.fidelity),
                   .seed = config.seed,
                   .messages = scenario.machine.notes};
  result.settings_before = twin.settings();
  result.position_error_before_p95_mm = PositionErrorP95_mm(twin);
  InterruptibleLink link(&twin.link());
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&link, options.transcript);
  }
  Bench bench;
  bench.link = recorder ? static_cast<Link*>(recorder.get()) : &link;
  bench.gauge = &twin.gauge();
  bench.person = &twin.person();
  bench.machine = scenario.machine.machine;
  bench.artefacts = scenario.artefacts;
  bench.instruments = config.instruments;
  constexpr std::size_t kUsualRows = 1024;
  result.rows.rows.reserve(kUsualRows);
  bench.record = &result.rows;
  bench.say = options.progress;

  const auto results = PerformAll(scenario, options, &twin, &bench, &result);

  if (recorder) recorder->Save();
  result.header = HeaderOfRun(bench);
  Collect(results, &result);
  result.settings_after = twin.settings();
  result.position_error_after_p95_mm = PositionErrorP95_mm(twin);
  result.machine_time_s = twin.machine_time_s();
  result.touches = twin.touches();
  Judge(scenario,
        {.machine = &config.machine,
         .effects = &config.effects,
         .before = result.settings_before,
         .after = result.settings_after,
         .results = results,
         .position_error_before_mm = result.position_error_before_p95_mm,
         .position_error_after_mm = result.position_error_after_p95_mm},
        &result);
  result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return result;
}

}  // namespace caltwin
