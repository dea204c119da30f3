#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renders/report.h"
#include "renders/run_pictures.h"
#include "scenarios/file_kind.h"
#include "scenarios/interrupt.h"
#include "scenarios/junit.h"
#include "scenarios/result_text.h"
#include "scenarios/runner.h"
#include "sim/base/text_file.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"
#include "tools/commands/spare_files.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMostSeeds = 1'000'000;

struct RunAsked {
  std::vector<std::string> files{};
  std::string fidelity{};
  std::optional<std::uint64_t> seed{};
  std::optional<std::int64_t> seeds{};
  std::string record{};
  std::string transcript{};
  std::string report{};
  std::string json{};
  std::string junit{};
  bool is_verbose = false;

  bool json_alone() const { return json == "-"; }
};

// All files are read before the first is run, so that a fault in the last does not
// waste the first's minutes, and shows together with the others.
std::vector<Scenario> ReadAll(const std::vector<fs::path>& files) {
  std::vector<Scenario> scenarios;
  std::vector<std::string> faults;
  for (const fs::path& file : files) {
    try {
      scenarios.push_back(ReadScenario(file));
    } catch (const InputError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  if (!faults.empty()) throw InputError(faults);
  return scenarios;
}

bool IsMany(const RunAsked& options, const std::vector<fs::path>& files) {
  std::error_code error;
  return options.seeds || files.size() != 1 ||
         fs::is_directory(options.files.front(), error);
}

void RefuseForMany(const RunAsked& options) {
  for (const auto& [name, value] : {std::pair{"--record", options.record},
                                    std::pair{"--transcript", options.transcript}}) {
    if (value.empty()) continue;
    throw InputError({},
                     fmt::format("{} keeps one run, and this is several", name),
                     "give one scenario file and no --seeds");
  }
}

// Where nothing is touched there are no rows.
void RefuseRecordOf(const RunAsked& options, const std::vector<Scenario>& scenarios) {
  for (const Scenario& scenario : scenarios) {
    if (options.record.empty() || scenario.kind->HasRows()) continue;
    throw InputError(
        {.file = "--record"},
        fmt::format("{} touches nothing: motors have no rows",
                    scenario.file.filename().string()),
        "--transcript keeps every line of the wire, --json what was found");
  }
}

RunOptions OptionsOf(const RunAsked& options,
                     const Scenario& scenario,
                     std::int64_t index,
                     ProgressLine* progress) {
  RunOptions run{.transcript = options.transcript,
                 .holds_transcript = !options.report.empty()};
  run.seed = options.seed.value_or(scenario.seed) + static_cast<std::uint64_t>(index);
  if (!options.fidelity.empty()) {
    run.fidelity = options.fidelity == "fast" ? Fidelity::kFast : Fidelity::kPhysics;
  }
  const std::string name = scenario.file.filename().string();
  run.progress = [progress, name](const std::string& text) {
    progress->Show(fmt::format("{}: {}", name, text));
  };
  return run;
}

std::vector<RunResult> RunAll(const RunAsked& options,
                              const std::vector<Scenario>& scenarios,
                              bool is_many) {
  ProgressLine progress;
  std::vector<RunResult> results;
  for (const Scenario& scenario : scenarios) {
    for (std::int64_t i = 0; i < options.seeds.value_or(1); ++i) {
      if (InterruptRequested()) return results;
      results.push_back(
          RunScenario(scenario, OptionsOf(options, scenario, i, &progress)));
      progress.Clear();
      if (is_many && !options.json_alone()) {
        std::cout << ResultLine(results.back(), MayPaint()) << "\n" << std::flush;
      }
    }
  }
  return results;
}

nlohmann::ordered_json JsonOfRun(const std::vector<RunResult>& results, bool is_many) {
  if (!is_many && !results.empty()) return ToJson(results.front());
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (const RunResult& result : results) runs.push_back(ToJson(result));
  const auto coverage = Coverage95(results);
  return {{"format", 1},
          {"runs", runs},
          {"passed", std::ranges::count_if(results, &RunResult::passed)},
          {"coverage95",
           coverage ? nlohmann::ordered_json(*coverage) : nlohmann::ordered_json()}};
}

// A folder of its own for each of several runs, named after its file and, where one
// file ran more than once, its seed.
fs::path ReportFolder(const RunAsked& options, const RunResult& result, bool is_many) {
  if (!is_many) return options.report;
  const std::string stem = fs::path(result.scenario).stem().string();
  return fs::path(options.report) /
         (options.seeds ? fmt::format("{}_seed_{}", stem, result.seed) : stem);
}

// A machine that its name does not find is named by its file, from the header's folder.
DataHeader HeaderFor(const RunAsked& options,
                     const RunResult& result,
                     const Machine& machine) {
  DataHeader header = result.header;
  const bool is_other = header.machine != machine.name;
  const bool is_found = machine.file.parent_path().filename() == machine.name;
  if (is_other || is_found || machine.file.empty()) return header;
  std::error_code error;
  const fs::path folder = fs::absolute(options.record).parent_path();
  header.machine = fs::relative(fs::absolute(machine.file), folder, error).string();
  return header;
}

void WriteOutputs(const RunAsked& options,
                  const std::vector<RunResult>& results,
                  const Machine& machine,
                  bool is_many) {
  if (!options.record.empty() && results.front().rows.rows.empty()) {
    std::cerr << "--record: nothing was touched or read, no file was written\n";
  } else if (!options.record.empty()) {
    WriteRows(options.record, results.front().rows);
    WriteDataHeader(fs::path(options.record).replace_extension(".yaml"),
                    HeaderFor(options, results.front(), machine));
  }
  if (!options.report.empty()) {
    for (const RunResult& result : results) {
      const fs::path folder = ReportFolder(options, result, is_many);
      WriteReport(result, PicturesOf(result), folder);
      if (!options.json_alone()) {
        std::cout << "report: " << (folder / "index.html").string() << "\n";
      }
    }
  }
  if (!options.junit.empty()) WriteTextFile(options.junit, JUnitText(results));
  if (options.json.empty()) return;
  const std::string json = JsonOfRun(results, is_many).dump(kJsonIndent) + "\n";
  if (options.json_alone()) {
    std::cout << json;
  } else {
    WriteTextFile(options.json, json);
  }
}

int ExitCodeOf(const std::vector<RunResult>& results) {
  if (InterruptRequested()) return kInterrupted;
  if (std::ranges::any_of(results, &RunResult::lost)) return kLost;
  return std::ranges::all_of(results, &RunResult::passed) ? kPassed : kCheckFailed;
}

void CheckSparesOfRun(const RunAsked& options, const std::vector<Scenario>& scenarios) {
  std::vector<NamedFile> read;
  for (const Scenario& scenario : scenarios) {
    read.push_back({"a scenario", scenario.file});
    read = Together({read, FilesOf(scenario.machine.machine)});
  }
  RefuseOverwriting(read,
                    Together({RowsAndHeader("--record", options.record),
                              {{"--transcript", options.transcript},
                               {"--json", options.json},
                               {"--junit", options.junit},
                               {"--report", options.report, /*is_folder=*/true}}}));
}

int RunRun(const RunAsked& options) {
  const std::vector<fs::path> files = FindScenarios(options.files);
  const bool is_many = IsMany(options, files);
  if (is_many) RefuseForMany(options);
  const std::vector<Scenario> scenarios = ReadAll(files);
  RefuseRecordOf(options, scenarios);
  CheckSparesOfRun(options, scenarios);
  const std::vector<RunResult> results = RunAll(options, scenarios, is_many);
  if (!options.json_alone()) {
    if (is_many) {
      std::cout << SummaryText(results);
    } else if (!results.empty()) {
      const bool is_brief = IsTerminal() && !options.is_verbose;
      std::cout << (is_brief ? ResultBrief(results.front(), MayPaint())
                             : ResultText(results.front(), MayPaint()));
    }
  }
  if (!results.empty()) {
    WriteOutputs(options, results, scenarios.front().machine.machine, is_many);
  }
  return ExitCodeOf(results);
}

}  // namespace

Action DeclareRun(CLI::App* app) {
  auto options = std::make_shared<RunAsked>();
  app->add_option("SCENARIO", options->files, "scenario files, or folders of them")
      ->required();
  app->add_option(
         "--fidelity", options->fidelity, "physics or fast, whatever the file says")
      ->check(CLI::IsMember({"physics", "fast"}));
  app->add_option(
         "--seed", options->seed, "the seed of all chance, in place of the file's")
      ->check(CLI::Range(0.0, 9e15));
  app->add_option(
         "--seeds", options->seeds, "run with so many seeds, from the first on")
      ->check(CLI::Range(std::int64_t{1}, kMostSeeds));
  app->add_option(
      "--record",
      options->record,
      "write every reading as rows (FILE.csv) and what explains them (FILE.yaml)");
  app->add_option(
      "--transcript", options->transcript, "write every line of G-code and its answer");
  app->add_option("--report", options->report, "write an HTML report into this folder");
  app->add_option(
      "--json", options->json, "write the result as JSON; - is stdout alone");
  app->add_option("--junit", options->junit, "write the checks as JUnit XML, for CI");
  app->add_flag("--verbose",
                options->is_verbose,
                "on a terminal too, all that is known of one run: how sure each number "
                "is, what was done, messages");
  app->footer(
      "Runs each scenario closed-loop and checks its `expect`. Of several files, or of "
      "several seeds, prints a line each and a summary.");
  return [options] {
    return RunRun(*options);
  };
}

}  // namespace caltwin
