#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <string_view>
#include <type_traits>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "renders/compare_report.h"
#include "renders/document.h"
#include "scenarios/compare_backlash.h"
#include "scenarios/host_lost.h"
#include "scenarios/interrupt.h"
#include "scenarios/kinds/compare_delta.h"
#include "scenarios/kinds/compare_levelling.h"
#include "scenarios/kinds/compare_measured.h"
#include "scenarios/museum.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"

namespace caltwin {
namespace {

constexpr int kMostMachines = 100000;

struct CompareAsked {
  std::string kind{};
  std::string machine = "random";
  int machines = 200;
  bool has_machines = false;  ///< Given, not by default.
  bool has_chance = false;    ///< --machine, --draws or --seed likewise.
  int draws = 200;
  std::uint64_t seed = 1;
  std::vector<std::string> engines{};
  std::string json{};
  std::string report{};
};

void Write(const CompareAsked& options,
           const std::string& text,
           const nlohmann::ordered_json& json) {
  if (options.json != "-") std::cout << text;
  if (options.json.empty()) return;
  const std::string dump = json.dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << dump;
  } else {
    WriteTextFile(options.json, dump);
  }
}

void WriteReportOf(const CompareAsked& options,
                   const std::vector<Contender>& contenders,
                   const std::string& text) {
  if (options.report.empty()) return;
  WriteDocument(
      CompareDocument(
          contenders,
          {.kind = options.kind,
           .text = text,
           .command = fmt::format(
               "caltwin compare {} --machines {} --seed {}{} --report {}",
               options.kind,
               options.machines,
               options.seed,
               options.engines.empty()
                   ? ""
                   : fmt::format(" --engines {}", fmt::join(options.engines, ",")),
               options.report)}),
      options.report);
  if (options.json != "-") {
    std::cout << "\nreport: " << options.report << "/index.html\n";
  }
}

int RunMeasured(const CompareAsked& options) {
  if (!options.report.empty()) {
    throw InputError({.file = "--report"},
                     "is of random machines",
                     "--json - has every figure of the measured one");
  }
  if (!options.engines.empty()) {
    throw InputError({.file = "--engines"},
                     "chooses among random machines' engines; on the measured one all "
                     "are held against what was measured",
                     "leave --machine or --engines away");
  }
  if (options.has_machines) {
    throw InputError({.file = "--machines"},
                     "is of random machines; only one was measured",
                     "--draws says how often each noisy row is drawn");
  }
  ProgressLine line;
  const auto tasks = CompareMeasuredDelta(
      options.draws, options.seed, [&](const std::string& name) { line.Show(name); });
  line.Clear();
  Write(options, MeasuredDeltaText(tasks), MeasuredDeltaJson(tasks, options.seed));
  return InterruptRequested() ? kInterrupted : kPassed;
}

// `compare(machines, seed, progress)`, with `engines` where their names may be given,
// and its result as text and as JSON.
template <auto compare, auto text, auto json>
int RunRandom(const CompareAsked& options) {
  ProgressLine line;
  const auto progress = [&](int done) {
    line.Show(fmt::format("machine {} of {}", done + 1, options.machines));
  };
  const auto comparison = [&] {
    if constexpr (std::is_invocable_v<decltype(compare),
                                      int,
                                      std::uint64_t,
                                      decltype(progress),
                                      std::vector<std::string>>) {
      return compare(options.machines, options.seed, progress, options.engines);
    } else {
      if (!options.engines.empty()) {
        throw InputError({.file = "--engines"},
                         "only engines of a delta are chosen by name",
                         "without it all of them are compared");
      }
      return compare(options.machines, options.seed, progress);
    }
  }();
  line.Clear();
  const std::string table = text(comparison);
  Write(options, table, json(comparison));
  WriteReportOf(options, ContendersOf(comparison), table);
  return comparison.is_interrupted ? kInterrupted : kPassed;
}

// Public faults beside their cures; nothing of it is random.
int RunMuseumOf(const CompareAsked& options) {
  if (options.has_machines || options.has_chance || !options.engines.empty() ||
      !options.report.empty()) {
    throw InputError({.file = "museum"},
                     "has its own machines and procedures",
                     "caltwin compare museum [--json FILE]");
  }
  const std::vector<Exhibit> exhibits =
      ReadExhibits(ShareFolder() / "scenarios" / "museum" / "exhibits.yaml");
  ProgressLine line;
  const std::vector<ExhibitShown> shown =
      RunMuseum(exhibits, [&](const std::string& fault) { line.Show(fault); });
  line.Clear();
  Write(options, MuseumText(shown), MuseumJson(shown));
  if (InterruptRequested()) return kInterrupted;
  return MuseumPassed(shown) ? kPassed : kCheckFailed;
}

/// What is calibrated on random machines; `on_measured`: on one that was measured.
struct Comparison {
  std::string_view name;
  int (*on_random)(const CompareAsked& options);
  int (*on_measured)(const CompareAsked& options) = nullptr;
};
constexpr std::array kComparisons = {
    Comparison{"delta",
               RunRandom<CompareDelta, DeltaComparisonText, DeltaComparisonJson>,
               RunMeasured},
    Comparison{
        "levelling",
        RunRandom<CompareLevelling, LevellingComparisonText, LevellingComparisonJson>},
    Comparison{
        "backlash",
        RunRandom<CompareBacklash, BacklashComparisonText, BacklashComparisonJson>},
    Comparison{"museum", RunMuseumOf}};

int RunCompare(const CompareAsked& options) {
  const auto* const asked =
      std::ranges::find(kComparisons, options.kind, &Comparison::name);
  if (options.machine != "measured" || options.kind == "museum")
    return asked->on_random(options);
  if (asked->on_measured != nullptr) return asked->on_measured(options);
  throw InputError({.file = "--machine"},
                   "only a delta has been measured",
                   "caltwin compare delta --machine measured");
}

}  // namespace

Action DeclareCompare(CLI::App* app) {
  const auto options = std::make_shared<CompareAsked>();
  app->add_option(
         "kind",
         options->kind,
         "what is calibrated: delta, levelling, backlash; or museum: public faults, "
         "each beside its cure")
      ->required()
      ->check(CLI::IsMember({"delta", "levelling", "backlash", "museum"}));
  const CLI::Option* const machines =
      app->add_option("--machines", options->machines, "how many random machines")
          ->capture_default_str()
          ->check(CLI::Range(1, kMostMachines));
  app->add_option("--machine",
                  options->machine,
                  "random, or measured: the one on which the public engines' own code "
                  "was measured, row by row")
      ->capture_default_str()
      ->check(CLI::IsMember({"random", "measured"}));
  app->add_option(
         "--draws", options->draws, "of each noisy row of the measured machine")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostMachines));
  app->add_option(
         "--engines",
         options->engines,
         "of a delta these alone, with commas between them: " + DeltaRivalNames() +
             ". kalico is the program that `tools/setup.sh --controllers` "
             "installs")
      ->delimiter(',');
  app->add_option("--seed", options->seed, "of the machines and their touches")
      ->capture_default_str();
  app->add_option(
      "--json", options->json, "write the figures as JSON; - for stdout alone");
  app->add_option("--report", options->report, "write an HTML report to this folder");
  return [app, options, machines] {
    options->has_machines = machines->count() > 0;
    options->has_chance =
        app->count("--machine") + app->count("--draws") + app->count("--seed") > 0;
    try {
      return RunCompare(*options);
    } catch (const HostLost& lost) {
      if (InterruptRequested()) return kInterrupted;
      std::cerr << "caltwin: " << lost.what() << "\n";
      return kLost;
    }
  };
}

}  // namespace caltwin
