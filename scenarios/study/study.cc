#include "scenarios/study/study.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "scenarios/study/vary.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMostTrials = 1'000'000'000;
constexpr std::int64_t kLargestSeed = 1'000'000'000'000;
constexpr std::size_t kMostScenarios = 1000;
constexpr std::size_t kLargestFile_bytes = 1'000'000;

// Every scenario named; their faults among the study's.
std::vector<Scenario> ReadScenarios(const YamlValue& list, const fs::path& folder) {
  std::vector<Scenario> scenarios;
  for (const YamlValue& name : list.List()) {
    try {
      scenarios.push_back(ReadScenario(folder / name.Text()));
    } catch (const InputError& error) {
      list.faults()->Add(error);
    }
  }
  if (list.faults()->empty() &&
      (scenarios.empty() || scenarios.size() > kMostScenarios)) {
    list.Fail(fmt::format("must name 1 to {} scenarios", kMostScenarios));
  }
  return scenarios;
}

// Each scenario as it is, or with each of the procedures.
std::vector<StudyCase> CasesOf(const std::vector<Scenario>& scenarios,
                               const std::optional<YamlValue>& compare) {
  std::vector<StudyCase> cases;
  for (const Scenario& scenario : scenarios) {
    if (!compare) {
      cases.push_back({.scenario = scenario});
      continue;
    }
    if (scenario.delta) {
      compare->Fail("is not known of a delta",
                    "name two scenarios, each with its own `calibrate:`");
      continue;
    }
    for (const CalibrationStep& step : ReadCalibrationSteps(*compare)) {
      cases.push_back({.scenario = scenario, .procedure = step.name});
      cases.back().scenario.calibrate = {step};
    }
  }
  return cases;
}

}  // namespace

std::string StudyCase::Name() const {
  const std::string stem = scenario.file.stem().string();
  return procedure.empty() ? stem : fmt::format("{}: {}", stem, procedure);
}

std::string Study::Fingerprint() const {
  std::string all = verbatim;
  for (const StudyCase& one : cases) all += one.scenario.verbatim;
  return Sha256(all + CALTWIN_VERSION);
}

Study ReadStudy(const fs::path& file) {
  Faults faults;
  YamlMap root = ReadYamlFile(file, &faults);
  Study study{.file = file, .verbatim = ReadTextFile(file, kLargestFile_bytes)};
  const auto body = root.Required("study");
  root.NoMoreKeys();
  faults.ThrowIfAny();
  YamlMap map = body->Map();
  study.about = map.TextOr("about", "");
  std::vector<Scenario> scenarios;
  if (const auto names = map.Required("scenarios")) {
    scenarios = ReadScenarios(*names, file.parent_path());
  }
  const auto vary = map.Optional("vary");
  if (vary) {
    for (Scenario& scenario : scenarios) Vary(vary->Map(), &scenario);
  }
  study.cases = CasesOf(scenarios, map.Optional("compare"));
  study.fidelity = map.WordOr("fidelity", "fast", {"physics", "fast"}) == "fast"
                       ? Fidelity::kFast
                       : Fidelity::kPhysics;
  if (const auto trials = map.Required("trials")) {
    study.trials = trials->Integer(1, kMostTrials);
  }
  study.seed = static_cast<std::uint64_t>(map.IntegerOr("seed", 1, 0, kLargestSeed));
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return study;
}

RunResult RunTrial(const Study& study, std::size_t of_case, std::int64_t trial) {
  return RunScenario(study.cases.at(of_case).scenario,
                     {.fidelity = study.fidelity,
                      .seed = study.seed,
                      .sample = static_cast<std::uint64_t>(trial)});
}

TrialResult KeptOf(const RunResult& run, std::size_t of_case, std::int64_t trial) {
  return {.trial = trial,
          .of_case = of_case,
          .status = run.outcome,
          .machine_time_s = run.machine_time_s,
          .touches = run.touches,
          .position_error_before_mm = run.position_error_before_p95_mm,
          .position_error_after_mm = run.position_error_after_p95_mm,
          .parameters = run.parameters};
}

}  // namespace caltwin
