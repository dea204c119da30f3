#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "scenarios/machine_file.h"
#include "sim/base/text_file.h"
#include "sim/measure/plan.h"
#include "tools/commands/command.h"
#include "tools/commands/plan_text.h"
#include "tools/commands/spare_files.h"

namespace caltwin {
namespace {

struct PlanAsked {
  std::string plan{};
  std::string machine{};
  std::string json{};
  std::optional<std::uint64_t> seed{};
};

MachineFile MachineOf(const PlanAsked& options, const Plan& plan) {
  if (!options.machine.empty()) {
    return ReadMachineWithTip(
        FindMachine(options.machine, "", {.file = options.machine}));
  }
  if (!plan.machine.empty()) {
    return ReadMachineWithTip(
        FindMachine(plan.machine, plan.file.parent_path(), {.file = options.plan}));
  }
  throw InputError({.file = options.plan},
                   "no machine is named",
                   "give the plan a key `machine: gantry_router`, or the command "
                   "`--machine FILE`");
}

int RunPlan(const PlanAsked& options) {
  const Plan plan = ReadPlan(options.plan);
  const MachineFile file = MachineOf(options, plan);
  RefuseOverwriting(Together({{{"the plan", options.plan}}, FilesOf(file.machine)}),
                    {{"--json", options.json}});
  const std::uint64_t seed = options.seed.value_or(plan.seed);
  const PlanAtlas result =
      AtlasOfPlan(plan, file.machine, DrawEffects(file.effects, seed, 0), seed);
  const std::string json = PlanAtlasJson(result).dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << json;
    return kPassed;
  }
  if (!options.json.empty()) WriteTextFile(options.json, json);
  std::cout << PlanAtlasText(options.plan, result);
  return kPassed;
}

}  // namespace

Action DeclarePlan(CLI::App* app) {
  const auto options = std::make_shared<PlanAsked>();
  app->add_option("PLAN", options->plan, "what would be measured (docs/plans.md)")
      ->required();
  app->add_option("--machine", options->machine, "in place of the plan's");
  app->add_option("--json", options->json, "the atlas as JSON; - for stdout alone");
  app->add_option("--seed", options->seed, "in place of the plan's");
  app->footer(
      "Nothing is measured: derivatives alone tell what a plan cannot see and what it "
      "cannot tell apart.");
  return [options] {
    return RunPlan(*options);
  };
}

}  // namespace caltwin
