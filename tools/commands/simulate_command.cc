#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "scenarios/file_kind.h"
#include "scenarios/interrupt.h"
#include "scenarios/machine_file.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/in_force.h"
#include "sim/measure/plan.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/performer.h"
#include "tools/commands/progress.h"
#include "tools/commands/spare_files.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr double kSecondsPerMinute = 60;

struct SimulateAsked {
  std::string plan{};
  std::string machine{};
  std::string truth{};
  std::string fidelity = "physics";
  std::optional<std::uint64_t> seed{};
  std::string out{};
};

fs::path MachineFileOf(const SimulateAsked& options, const Plan& plan) {
  if (!options.machine.empty()) {
    return FindMachine(options.machine, "", {.file = options.machine});
  }
  if (!plan.machine.empty()) {
    return FindMachine(plan.machine, plan.file.parent_path(), {.file = options.plan});
  }
  throw InputError({.file = options.plan},
                   "no machine is named",
                   "give the plan a key `machine: gantry_router`, or the command "
                   "`--machine FILE`");
}

// As the data's header says it: a name, or the file's path from the header's folder.
std::string WrittenFrom(const SimulateAsked& options,
                        const Plan& plan,
                        const fs::path& machine) {
  const std::string& said = options.machine.empty() ? plan.machine : options.machine;
  const bool is_name =
      fs::path(said).extension().empty() && said.find('/') == std::string::npos;
  if (is_name) return said;
  const fs::path folder = fs::absolute(options.out).parent_path();
  return fs::proximate(fs::absolute(machine), folder).generic_string();
}

Plan PlanOf(const SimulateAsked& options) {
  if (const FileKind kind = KindOf(options.plan); kind != FileKind::kPlan) {
    throw InputError(
        {.file = options.plan},
        fmt::format("this is a {}, where a plan is wanted", ToString(kind)),
        "a plan has a list of `campaigns`; examples/plans has some");
  }
  return ReadPlan(options.plan);
}

void CheckOut(const std::string& out) {
  if (fs::path(out).extension() == ".csv") return;
  throw InputError({.file = "--out"},
                   fmt::format("'{}' does not end in .csv", out),
                   "rows are written there, and what explains them beside it, in a "
                   ".yaml of the same name");
}

int Simulate(const SimulateAsked& options) {
  CheckOut(options.out);
  const Plan plan = PlanOf(options);
  const std::uint64_t seed = options.seed.value_or(plan.seed);
  const fs::path machine = MachineFileOf(options, plan);
  const MachineFile file = ReadMachineWithTip(machine);
  RefuseOverwriting(
      Together({{{"the plan", options.plan}, {"the truth", options.truth}},
                FilesOf(file.machine)}),
      RowsAndHeader("--out", options.out));
  const Performer performer = PerformerOf(
      file, {.truth = options.truth, .fidelity = options.fidelity, .seed = seed});
  PlannedSession session = PlanSession(plan, performer.machine, seed);
  session.header.machine = WrittenFrom(options, plan, machine);
  session.header.settings["1"] =
      AsHeader(performer.machine.settings, *performer.machine.kind);
  for (Row& row : session.rows) row.settings = "1";

  ProgressLine progress;
  const std::size_t count = session.rows.size();
  std::size_t done = 0;
  const auto interrupted = [&] {
    if (done % 50 == 0) progress.Show(fmt::format("{} of {} readings", done, count));
    ++done;
    return InterruptRequested();
  };
  const RowTable table = performer.perform(
      {.header = session.header, .interrupted = interrupted}, std::move(session.rows));
  progress.Clear();
  WriteRows(options.out, table);
  WriteDataHeader(fs::path(options.out).replace_extension(".yaml"), session.header);
  std::cout << fmt::format(
      "{}: {} readings of {} campaign{}, {:.0f} min of machine time\n",
      options.out,
      table.rows.size(),
      plan.campaigns.size(),
      plan.campaigns.size() == 1 ? "" : "s",
      session.duration_s / kSecondsPerMinute);
  return InterruptRequested() ? kInterrupted : kPassed;
}

}  // namespace

Action DeclareSimulate(CLI::App* app) {
  auto options = std::make_shared<SimulateAsked>();
  app->add_option("PLAN", options->plan, "what to measure (docs/plans.md)")->required();
  app->add_option("--out", options->out, "rows to write (DATA.csv, and DATA.yaml)")
      ->required();
  app->add_option("--machine", options->machine, "in place of the plan's");
  app->add_option("--truth", options->truth, "effects and settings it truly has");
  app->add_option(
         "--fidelity", options->fidelity, "physics (MuJoCo) or fast (closed forms)")
      ->check(CLI::IsMember({"physics", "fast"}))
      ->capture_default_str();
  app->add_option("--seed", options->seed, "in place of the plan's");
  app->footer(
      "The same plan, machine, truth and seed give the same bytes.\n"
      "`caltwin explain iso230` says what a campaign does and its options.");
  return [options] {
    return Simulate(*options);
  };
}

}  // namespace caltwin
