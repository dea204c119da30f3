#include "scenarios/study/study.h"

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/kinds.h"
#include "scenarios/study/adaptive.h"
#include "scenarios/study/vary.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMostTrials = 1'000'000'000;
constexpr std::int64_t kMostUnkeptTrials = 1'000'000'000'000;
constexpr std::int64_t kLargestSeed = 1'000'000'000'000;
constexpr std::size_t kMostScenarios = 1000;
constexpr std::int64_t kMostShards = 1'000'000;

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

// The axis in a dotted name, "x" of "backlash.x.gap_mm"; else empty.
std::string AxisIn(const std::string& name) {
  for (const char* axis : {"x", "y", "z"}) {
    if (("." + name + ".").find(fmt::format(".{}.", axis)) != std::string::npos) {
      return axis;
    }
  }
  return "";
}

// Of procedures that are named alone: the first axis that the scenario's own steps
// name, or else what is varied.
std::string UsualAxis(const Scenario& scenario, const std::optional<YamlValue>& vary) {
  const YAML::Node root = YAML::Load(scenario.verbatim);
  for (const YAML::Node& step : root["calibrate"]) {
    if (!step.IsMap() || !step.begin()->second.IsMap()) continue;
    const YAML::Node axis = step.begin()->second["axis"];
    if (axis && axis.IsScalar() && !AxisIn(axis.Scalar()).empty()) return axis.Scalar();
  }
  if (!vary || !vary->is_map()) return "x";
  for (const auto& [name, value] : vary->Map().Entries()) {
    const std::string axis = AxisIn(name);
    if (!axis.empty()) return axis;
  }
  return "x";
}

// What contenders are called: their procedures, with their options where two of them
// are of one.
std::vector<std::string> ContenderNames(const YamlValue& compare,
                                        const std::vector<CalibrationStep>& steps) {
  std::vector<std::string> names;
  const std::vector<YamlValue> written = compare.List();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto is_same = [&](const CalibrationStep& other) {
      return other.name == steps[i].name;
    };
    if (std::ranges::count_if(steps, is_same) == 1 || written.size() != steps.size()) {
      names.push_back(steps[i].name);
      continue;
    }
    std::istringstream words(written[i].AsWritten());
    names.emplace_back();
    for (std::string word; words >> word;) {
      names.back() += (names.back().empty() ? "" : " ") + word;
    }
  }
  return names;
}

// Results tell cases apart by their names.
void RefuseTwice(const std::vector<StudyCase>& cases, const YamlValue& at) {
  std::set<std::string> names;
  for (const StudyCase& one : cases) {
    if (names.insert(one.Name()).second) continue;
    at.Fail(fmt::format("has '{}' twice, and results could not tell which is which",
                        one.Name()),
            "leave one out, or give the scenario's file another name");
    return;
  }
}

// Each scenario as it is, or with each of the procedures.
std::vector<StudyCase> CasesOf(const std::vector<Scenario>& scenarios,
                               const std::optional<YamlValue>& vary,
                               const std::optional<YamlValue>& compare) {
  std::vector<StudyCase> cases;
  for (const Scenario& scenario : scenarios) {
    if (!compare) {
      cases.push_back({.scenario = scenario});
      continue;
    }
    const std::string axis = UsualAxis(scenario, vary);
    const std::vector<CalibrationStep> steps =
        ReadCalibrationSteps(*compare, *scenario.kind, scenario.machine.machine, axis);
    const std::vector<std::string> names = ContenderNames(*compare, steps);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      cases.push_back({.scenario = scenario, .procedure = names[i]});
      cases.back().scenario.calibrate = {steps[i]};
    }
  }
  return cases;
}

// The plan's machine with what is varied of it, and the design of its rows.
void ReadPlanStudy(const YamlValue& plan,
                   const std::optional<YamlValue>& vary,
                   Study* study) {
  const fs::path file = study->file.parent_path() / plan.Text();
  try {
    const Plan read = ReadPlan(file);
    Scenario varied;
    varied.file = file;
    varied.verbatim = ReadTextFile(file, kLargestFile_bytes);
    varied.machine = ReadMachineWithTip(
        FindMachine(read.machine, file.parent_path(), {.file = file.string()}));
    varied.kind = AnyKindScenario(UsualKind());
    varied.effects = varied.machine.effects;
    varied.notes = varied.machine.draws;
    if (vary) Vary(vary->Map(), &varied);
    if (!varied.settings.empty() || !varied.varied.empty()) {
      vary->Fail("names more than effects",
                 "of a plan, effects are varied; its instruments are the plan's");
    }
    if (!plan.faults()->empty()) return;
    study->cases = {{.scenario = varied}};
    study->plan = std::make_shared<PlanStudy>(file, std::move(varied), study->seed);
  } catch (const InputError& error) {
    plan.faults()->Add(error);
  }
}

// JCGM 101 7.9: as many trials as it takes.
void ReadAdaptive(const YamlValue& adaptive, bool has_trials, Study* study) {
  constexpr std::int64_t kUsualMost = 1'000'000;
  YamlMap map = adaptive.Map();
  study->adaptive_digits = static_cast<int>(map.IntegerOr("digits", 2, 1, 4));
  study->most_trials = map.IntegerOr("most_trials", kUsualMost, 20'000, kMostTrials);
  map.NoMoreKeys();
  if (study->most_trials % kAdaptiveBatch != 0) {
    adaptive.Fail(fmt::format("has most_trials {}, which is no whole number of batches",
                              study->most_trials),
                  fmt::format("a batch is {} trials", kAdaptiveBatch));
  }
  if (has_trials) {
    adaptive.Fail("stands beside `trials`", "one of the two says how many");
  } else if (!study->keeps_trials) {
    adaptive.Fail("needs the trials kept", "write `keep: all`");
  }
}

// How many trials, how, and what is kept of them.
void ReadHow(YamlMap* map, Study* study) {
  const std::string fidelity =
      map->WordOr("fidelity", "fast", {"physics", "fast", "linear"});
  study->is_linear = fidelity == "linear";
  study->fidelity = fidelity == "physics" ? Fidelity::kPhysics : Fidelity::kFast;
  const bool fits = study->plan ? fidelity != "physics" : fidelity != "linear";
  if (!fits && map->faults()->empty()) {
    map->Optional("fidelity")
        ->Fail(study->plan ? "is not known of a plan" : "is for plans alone",
               study->plan ? "write `fast` or `linear`"
                           : "write `fast`, or `plan: FILE` in place of `scenarios`");
  }
  const std::string keep =
      map->WordOr("keep", study->is_linear ? "none" : "all", {"all", "none"});
  study->keeps_trials = keep == "all";
  if (const auto adaptive = map->Optional("adaptive")) {
    ReadAdaptive(*adaptive, map->Has("trials"), study);
    map->Optional("trials");
  } else if (const auto trials = map->Required("trials")) {
    study->trials =
        trials->Integer(1, study->keeps_trials ? kMostTrials : kMostUnkeptTrials);
    study->most_trials = study->trials;
  }
}

std::vector<std::string> NotesOf(const std::vector<StudyCase>& cases,
                                 const Faults& own) {
  std::vector<std::string> notes = own.notes();
  for (const StudyCase& one : cases) {
    for (const std::string& note : one.scenario.notes) {
      if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
    }
  }
  return notes;
}

}  // namespace

std::string StudyCase::Name() const {
  const std::string stem = scenario.file.stem().string();
  return procedure.empty() ? stem : fmt::format("{}: {}", stem, procedure);
}

std::string Study::Fingerprint() const {
  std::string all = verbatim;
  for (const StudyCase& one : cases) {
    all += one.scenario.verbatim + one.scenario.machine.verbatim;
  }
  return Sha256(all + CALTWIN_VERSION);
}

std::string Study::FidelityWord() const {
  return is_linear ? "linear" : ToString(fidelity);
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
  study.seed = static_cast<std::uint64_t>(map.IntegerOr("seed", 1, 0, kLargestSeed));
  const auto vary = map.Optional("vary");
  const auto plan = map.Optional("plan");
  if (plan) {
    ReadPlanStudy(*plan, vary, &study);
  } else if (const auto names = map.Required("scenarios")) {
    std::vector<Scenario> scenarios = ReadScenarios(*names, file.parent_path());
    if (vary) {
      for (Scenario& scenario : scenarios) {
        Vary(vary->Map(), &scenario);
        scenario.kind->CheckVaried(scenario, &faults);
      }
    }
    const auto compare = map.Optional("compare");
    study.cases = CasesOf(scenarios, vary, compare);
    RefuseTwice(study.cases, compare ? *compare : *names);
  }
  ReadHow(&map, &study);
  map.NoMoreKeys();
  faults.ThrowIfAny();
  study.notes = NotesOf(study.cases, faults);
  return study;
}

std::string Shard::Text() const {
  return fmt::format("{}/{}", index + 1, count);
}

Shard ReadShard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto number = [&](std::size_t from, std::size_t to) {
    std::int64_t value = 0;
    const char* const end = text.data() + to;
    const auto read = std::from_chars(text.data() + from, end, value);
    return read.ec == std::errc() && read.ptr == end ? value : -1;
  };
  if (slash != std::string::npos) {
    const std::int64_t part = number(0, slash);
    const std::int64_t count = number(slash + 1, text.size());
    if (part >= 1 && part <= count && count <= kMostShards) {
      return {.index = part - 1, .count = count};
    }
  }
  throw InputError(
      {},
      fmt::format("--shard '{}' is not I/N with I from 1 to N, N at most {}",
                  text,
                  kMostShards),
      "`--shard 2/5` is the second of five");
}

RunResult RunTrial(const Study& study, std::size_t of_case, std::int64_t trial) {
  if (study.plan) {
    return study.is_linear ? study.plan->Linear(trial) : study.plan->Fast(trial);
  }
  const Scenario& scenario = study.cases.at(of_case).scenario;
  const auto sample = static_cast<std::uint64_t>(trial);
  RunResult result = RunScenario(
      scenario, {.fidelity = study.fidelity, .seed = study.seed, .sample = sample});
  for (const auto& [name, value] :
       DrawnNumbers(scenario.machine.machine, scenario.varied, study.seed, sample)) {
    result.parameters.push_back(
        {.name = name, .unit = name.ends_with("_mm") ? "mm" : "um", .injected = value});
  }
  return result;
}

std::string CauseOf(const RunResult& run) {
  if (run.outcome == "recovers" || run.outcome == "fitted") return "";
  std::string missed;
  for (const ParameterResult& parameter : run.parameters) {
    if (parameter.passed.value_or(true)) continue;
    missed += (missed.empty() ? "missed " : ", ") + parameter.name;
  }
  if (run.outcome == "misses" && !missed.empty()) return missed;
  return run.messages.empty() ? "" : run.messages.back().text;
}

TrialResult KeptOf(const RunResult& run, std::size_t of_case, std::int64_t trial) {
  return {.trial = trial,
          .of_case = of_case,
          .status = run.outcome,
          .machine_time_s = run.machine_time_s,
          .touches = run.touches,
          .position_error_before_mm = run.position_error_before_p95_mm,
          .position_error_after_mm = run.position_error_after_p95_mm,
          .parameters = run.parameters,
          .message = CauseOf(run)};
}

}  // namespace caltwin
