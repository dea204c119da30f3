#include "scenarios/runner.h"

#include <algorithm>
#include <ctime>
#include <memory>

#include <fmt/format.h>

#include "scenarios/interruptible_link.h"
#include "scenarios/judge.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

// After these the machine is not where the next step would expect it, or nobody wants
// it to go on.
bool StopsTheRun(Ending ending) {
  switch (ending) {
    case Ending::kNoTrigger:
    case Ending::kCollision:
    case Ending::kAlarm:
    case Ending::kLinkLost:
    case Ending::kRefused:
      return true;
    case Ending::kDone:
    case Ending::kUnconverged:
    case Ending::kReadsZero:
    case Ending::kConfounded:
      break;
  }
  return false;
}

ProcedureResult PerformExternal(const ExternalCommand& command,
                                KindTrial* trial,
                                RunResult* result) {
  const ExternalRun run = RunExternal(command, trial->bench());
  ProcedureResult done = run.result;
  trial->EndExternal(&done);
  result->lost = result->lost || run.lost();
  result->checks.push_back({.name = "external",
                            .expected = "exited with 0",
                            .found = ToString(run.end),
                            .passed = run.passed()});
  return done;
}

ProcedureResult PerformStep(const CalibrationStep& step,
                            KindTrial* trial,
                            RunResult* result) {
  trial->BeginStep(step);
  ProcedureResult done = step.external ? PerformExternal(*step.external, trial, result)
                         : step.procedure ? step.procedure(trial->bench())
                                          : step.perform(trial);
  trial->EndStep(step, &done);
  return done;
}

std::vector<ProcedureResult> PerformAll(const Scenario& scenario,
                                        const RunOptions& options,
                                        KindTrial* trial,
                                        RunResult* result) {
  const std::size_t count = scenario.calibrate.size();
  std::vector<ProcedureResult> results;
  for (std::size_t i = 0; i < count; ++i) {
    const CalibrationStep& step = scenario.calibrate[i];
    options.progress(fmt::format("{}/{} {}", i + 1, count, step.name));
    results.push_back(PerformStep(step, trial, result));
    if (InterruptRequested()) {
      result->interrupted = true;
      break;
    }
    const Ending ending = results.back().ending;
    if (ending == Ending::kLinkLost) result->lost = true;
    if (StopsTheRun(ending) || (step.external && !result->checks.back().passed)) {
      if (i + 1 < count) {
        result->messages.push_back(
            fmt::format("{} of {} steps were not reached", count - i - 1, count));
      }
      break;
    }
  }
  return results;
}

// Procedures repeat what they said before measuring and what the one before them said:
// once is enough.
void AddOnce(const Message& message, std::vector<Message>* messages) {
  if (std::ranges::find(*messages, message.text, &Message::text) == messages->end()) {
    messages->push_back(message);
  }
}

void Collect(const std::vector<ProcedureResult>& results, RunResult* result) {
  for (const ProcedureResult& part : results) {
    AddDone(part, result);
    for (const Message& message : part.messages) {
      AddOnce(message, &result->messages);
    }
    if (!part.fault.empty()) {
      AddOnce(MachineSaid(part.fault), &result->messages);
    }
  }
}

// Whether any step is one that tells or sets something: lines of G-code alone, and what
// an operator does, calibrate nothing.
bool Calibrates(const Scenario& scenario) {
  if (scenario.klipper || scenario.linuxcnc) return true;
  const Procedures known = scenario.kind->KnownProcedures();
  return std::ranges::any_of(scenario.calibrate, [&](const CalibrationStep& step) {
    return step.external || FindProcedure(step.name, known) != nullptr;
  });
}

void Judge(const Scenario& scenario,
           const std::vector<ProcedureResult>& results,
           KindTrial* trial,
           RunResult* result) {
  const Expectation& expect = scenario.expect;
  trial->AddParameters(expect, results, result);
  std::vector<CheckResult> external;
  std::swap(external, result->checks);
  const bool all_met = MeetExpectations(expect, result);
  TrueEnd end = trial->End(results, result);
  const bool is_told = std::ranges::any_of(
      result->parameters,
      [](const ParameterResult& row) { return row.error.has_value(); });
  end.told_wrong = end.told_wrong || (!Calibrates(scenario) && !is_told);
  if (end.figure) {
    result->figure_before = end.figure->before;
    result->figure_after = end.figure->after;
  }
  result->outcome = JudgeOutcome(results, end, all_met);
  CheckParameters(expect, results, result);
  for (const FigureExpectation& expected : expect.figures) {
    const double found = expected.name == "machine_time_s" ? result->machine_time_s
                         : expected.name == "touches"
                             ? result->touches
                             : trial->Figure(expected.name, *result);
    CheckFigure(expected, found, result);
  }
  CheckMessages(expect.messages, results, result);
  result->checks.insert(result->checks.end(), external.begin(), external.end());
  CheckOutcome(expect.outcome, result);
  result->passed = AllPassed(*result);
}

std::unique_ptr<KindTrial> Begin(const Scenario& scenario, const Chance& chance) {
  if (scenario.klipper) return scenario.kind->BeginUnderKlipper(scenario, chance);
  if (scenario.linuxcnc) return scenario.kind->BeginUnderLinuxCnc(scenario, chance);
  return scenario.kind->Begin(scenario, chance);
}

}  // namespace

Chance ChanceOf(const Scenario& scenario, const RunOptions& options) {
  return {.seed = options.seed.value_or(scenario.seed),
          .sample = options.sample,
          .fidelity = options.fidelity.value_or(scenario.fidelity)};
}

RunResult RunScenario(const Scenario& scenario, const RunOptions& options) {
  const std::clock_t start = std::clock();
  const Chance chance = ChanceOf(scenario, options);
  const std::unique_ptr<KindTrial> trial = Begin(scenario, chance);
  RunResult result{
      .scenario = scenario.file.string(),
      .about = scenario.about,
      .verbatim = scenario.verbatim,
      .machine = scenario.machine.machine.name,
      .fidelity = ToString(chance.fidelity),
      .seed = chance.seed,
      .messages = {scenario.machine.notes.begin(), scenario.machine.notes.end()}};
  trial->Before(&result);
  InterruptibleLink link(trial->wire());
  std::unique_ptr<RecordingLink> recorder;
  if (options.holds_transcript || !options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&link, options.transcript);
  }
  trial->Connect(recorder ? static_cast<Link*>(recorder.get()) : &link);
  trial->bench()->say = options.progress;

  const auto results = PerformAll(scenario, options, trial.get(), &result);

  trial->Finish(&result);
  if (recorder) recorder->Save();
  if (options.holds_transcript) result.transcript = recorder->text();
  Collect(results, &result);
  Judge(scenario, results, trial.get(), &result);
  result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return result;
}

}  // namespace caltwin
