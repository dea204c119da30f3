#include "scenarios/museum.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/host_lost.h"
#include "scenarios/interrupt.h"
#include "scenarios/runner.h"
#include "sim/base/input_error.h"
#include "sim/base/yaml.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kJudged = "judged";

ShownRun ShowRun(const fs::path& file, const std::string& figure, std::string* unit) {
  const RunResult result = RunScenario(ReadScenario(file));
  ShownRun run{.outcome = result.outcome, .passed = result.passed};
  if (result.lost) throw HostLost(result.outcome);
  if (figure == kJudged) {
    run.before = result.figure_before;
    run.after = result.figure_after;
    return run;
  }
  const auto parameter =
      std::ranges::find(result.parameters, figure, &ParameterResult::name);
  if (parameter == result.parameters.end()) {
    throw InputError({.file = file.string()},
                     fmt::format("its run has no parameter '{}'", figure));
  }
  *unit = parameter->unit;
  if (parameter->error) run.after = std::abs(*parameter->error);
  return run;
}

std::string Figure(const std::optional<double>& value) {
  if (!value) return "-";
  if (!std::isfinite(*value)) return "nowhere";  // It reaches the bed no more.
  return fmt::format("{:.3g}", *value + 0.0);
}

nlohmann::ordered_json RunJson(const ShownRun& run) {
  const auto number = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  return {{"outcome", run.outcome},
          {"before", number(run.before)},
          {"after", number(run.after)},
          {"passed", run.passed}};
}

}  // namespace

std::vector<Exhibit> ReadExhibits(const fs::path& file) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  std::vector<Exhibit> exhibits;
  if (const auto list = map.Required("exhibits")) {
    for (const YamlValue& one : list->List()) {
      YamlMap entry = one.Map();
      Exhibit exhibit{.fault = entry.Text("fault"), .source = entry.Text("source")};
      exhibit.as_published =
          (file.parent_path() / entry.Text("as_published")).lexically_normal();
      exhibit.cured = (file.parent_path() / entry.Text("cured")).lexically_normal();
      exhibit.figure = entry.TextOr("figure", std::string(kJudged));
      exhibit.needs = entry.WordOr("needs", "", {"", "klipper", "linuxcnc"});
      exhibit.cure_changes = entry.TextOr("cure_changes", "");
      entry.NoMoreKeys();
      exhibits.push_back(std::move(exhibit));
    }
  }
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return exhibits;
}

std::vector<ExhibitShown> RunMuseum(
    const std::vector<Exhibit>& exhibits,
    const std::function<void(const std::string&)>& progress) {
  std::vector<ExhibitShown> all;
  for (const Exhibit& exhibit : exhibits) {
    if (InterruptRequested()) break;
    progress(exhibit.fault);
    ExhibitShown shown{.exhibit = exhibit};
    try {
      shown.fault = ShowRun(exhibit.as_published, exhibit.figure, &shown.unit);
      shown.cure = ShowRun(exhibit.cured, exhibit.figure, &shown.unit);
    } catch (const InputError& error) {
      if (exhibit.needs.empty()) throw;
      shown.not_run = error.faults().front();
    }
    all.push_back(std::move(shown));
  }
  return all;
}

bool MuseumPassed(const std::vector<ExhibitShown>& shown) {
  return std::ranges::all_of(shown, [](const ExhibitShown& one) {
    return !one.not_run.empty() || (one.fault.passed && one.cure.passed);
  });
}

std::string MuseumText(const std::vector<ExhibitShown>& shown) {
  std::string text;
  std::size_t ran = 0;
  for (const ExhibitShown& one : shown) {
    if (!one.not_run.empty()) continue;
    ++ran;
    text +=
        fmt::format("{:>9} -> {:<9} cured {:<9} {:<5} {}{}\n          {} ({}; {})\n",
                    Figure(one.fault.before),
                    Figure(one.fault.after),
                    Figure(one.cure.after),
                    one.unit,
                    one.exhibit.fault,
                    one.fault.passed && one.cure.passed ? "" : "  NOT AS EXPECTED",
                    one.exhibit.source,
                    one.exhibit.figure,
                    one.fault.outcome);
  }
  for (const ExhibitShown& one : shown) {
    if (one.not_run.empty()) continue;
    text += fmt::format("not run, it needs {}: {}\n          {}\n",
                        one.exhibit.needs,
                        one.exhibit.fault,
                        one.not_run);
  }
  return fmt::format(
             "{} public faults, each on a machine with known truth: the error as "
             "found, "
             "as the fault leaves it, and with its cure\n\n",
             ran) +
         text;
}

nlohmann::ordered_json MuseumJson(const std::vector<ExhibitShown>& shown) {
  nlohmann::ordered_json exhibits = nlohmann::ordered_json::array();
  for (const ExhibitShown& one : shown) {
    exhibits.push_back({{"fault", one.exhibit.fault},
                        {"source", one.exhibit.source},
                        {"figure", one.exhibit.figure},
                        {"unit", one.unit},
                        {"as_published", RunJson(one.fault)},
                        {"cured", RunJson(one.cure)},
                        {"not_run", one.not_run}});
  }
  return {{"format", 1}, {"kind", "museum"}, {"exhibits", exhibits}};
}

}  // namespace caltwin
