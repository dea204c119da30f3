#include <array>
#include <iostream>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

constexpr std::array kCommands = {
    Command{"run", "run scenarios and check what they expect", DeclareRun},
    Command{"calibrate", "run a procedure on a machine", DeclareCalibrate},
    Command{"diagnose", "say what measured rows tell of a machine", DeclareDiagnose},
    Command{
        "predict", "hold the frozen model of one run against another", DeclarePredict},
    Command{"compare", "rival procedures on the same machines", DeclareCompare},
    Command{"study", "Monte Carlo over many machines", DeclareStudy},
    Command{"plan", "what a measuring plan can and cannot see", DeclarePlan},
    Command{"simulate", "the twin performs a measuring plan", DeclareSimulate},
    Command{"serve", "let real clients talk to a twin", DeclareServe},
    Command{"oracle", "score a program that calibrates deltas", DeclareOracle},
    Command{"klipper", "Klipper's own host drives a twin", DeclareKlipper},
    Command{"linuxcnc", "LinuxCNC drives a twin", DeclareLinuxCnc},
    Command{"import", "read somebody else's measurements", DeclareImport},
    Command{"iso230", "the ISO 230-2 sheet of measured rows", DeclareIso230},
    Command{"render", "an off-screen picture", DeclareRender},
    Command{"new", "a starter file for one's own machine", DeclareNew},
    Command{"validate", "check files without running anything", DeclareValidate},
    Command{"explain", "what an effect, procedure, unit or key means", DeclareExplain}};

constexpr const char* kFooter =
    "Exit codes: 0 done and passed, 1 a check failed, 2 bad input, 3 a process or link "
    "was lost, 130 interrupted.\nStart with: caltwin run scenarios/first_light.yaml";

}  // namespace

std::span<const Command> AllCommands() {
  return kCommands;
}

int RunCommandLine(int argc, const char* const* argv) {
  CLI::App app(
      "caltwin: digital twins of machine tools and printers, the calibration that runs "
      "against them over G-code, and the diagnosis of measured data.",
      "caltwin");
  app.footer(kFooter);
  app.set_version_flag("--version", std::string("caltwin ") + CALTWIN_VERSION);
  app.require_subcommand(1);
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Command& command : AllCommands()) {
    CLI::App* sub =
        app.add_subcommand(std::string(command.name), std::string(command.about));
    actions.emplace_back(sub, command.declare(sub));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    throw InputError({},
                     fmt::format("caltwin: {}", error.what()),
                     "`caltwin --help` and `caltwin COMMAND --help` say what there is");
  }
  for (const auto& [sub, action] : actions) {
    if (sub->parsed()) return action();
  }
  return kPassed;
}

}  // namespace caltwin
