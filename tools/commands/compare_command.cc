#include <iostream>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/compare_delta.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"

namespace caltwin {
namespace {

constexpr int kMostMachines = 100000;

struct Options {
  std::string kind{};
  int machines = 200;
  std::uint64_t seed = 1;
  std::string json{};
};

int Run(const Options& options) {
  constexpr int kJsonIndent = 2;
  ProgressLine line;
  const DeltaComparison comparison =
      CompareDelta(options.machines, options.seed, [&](int done) {
        line.Show(fmt::format("machine {} of {}", done + 1, options.machines));
      });
  line.Clear();
  if (options.json != "-") std::cout << DeltaComparisonText(comparison);
  if (!options.json.empty()) {
    const std::string json = DeltaComparisonJson(comparison).dump(kJsonIndent) + "\n";
    if (options.json == "-") {
      std::cout << json;
    } else {
      WriteTextFile(options.json, json);
    }
  }
  return comparison.is_interrupted ? kInterrupted : kPassed;
}

}  // namespace

Action DeclareCompare(CLI::App* app) {
  const auto options = std::make_shared<Options>();
  app->add_option("kind", options->kind, "what is calibrated: delta")
      ->required()
      ->check(CLI::IsMember({"delta"}));
  app->add_option("--machines", options->machines, "how many random machines")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostMachines));
  app->add_option("--seed", options->seed, "of the machines and their touches")
      ->capture_default_str();
  app->add_option(
      "--json", options->json, "write the figures as JSON; - for stdout alone");
  return [options] {
    return Run(*options);
  };
}

}  // namespace caltwin
