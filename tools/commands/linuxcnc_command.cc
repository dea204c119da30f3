#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/interrupt.h"
#include "scenarios/linuxcnc/config_files.h"
#include "scenarios/linuxcnc/host.h"
#include "sim/base/text_file.h"
#include "sim/controllers/linuxcnc/config.h"
#include "sim/machine/machine.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/served.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

struct LinuxCncAsked {
  TwinOptions twin{};
  std::vector<std::string> lines{}, set{};
  std::string program{}, ini{}, json{}, log{};
  bool is_unhomed = false;
  bool is_latched = false;
  double bounce_ms = 0;
  double patience_s = 10, longest_s = 7200;
};

/// What was asked, and what came of it.
struct Done {
  std::string what{};
  LinuxCncAnswer answer{};
  double machine_s = 0;  ///< When it was done, by LinuxCNC's clock.
};

LinuxCncFiles FilesOf(const LinuxCncAsked& asked,
                      const ServedKind& kind,
                      const fs::path& machine) {
  const Machine read = ReadAnyMachineFile(machine).machine;
  // Also with an INI file of one's own: whether LinuxCNC can drive such a machine.
  const linuxcnc::MachineText text = kind.linuxcnc(read);
  auto files = asked.ini.empty() ? linuxcnc::ConfigFiles(text, "dummy", "caltwin")
                                 : FilesBesideIni(asked.ini);
  for (const std::string& one : asked.set) {
    WithIniSetting(files.front().second, one, "--set " + one);  // Refused now.
  }
  if (!asked.program.empty()) {
    const LinuxCncFiles beside = SubroutinesBeside(asked.program);
    files.insert(files.end(), beside.begin(), beside.end());
  }
  return files;
}

std::string Placed(const std::array<double, 3>& at_mm) {
  return fmt::format("X{:.4f} Y{:.4f} Z{:.4f}", at_mm[0], at_mm[1], at_mm[2]);
}

void Print(const Done& done) {
  for (const std::string& text : done.answer.messages) std::cout << text << '\n';
  for (const auto& at_mm : done.answer.probed_mm) {
    std::cout << "probed at " << Placed(at_mm) << '\n';
  }
  for (const std::string& text : done.answer.errors) {
    std::cout << "LinuxCNC refused: " << text << '\n';
  }
  if (!done.answer.done && done.answer.errors.empty()) {
    std::cout << "LinuxCNC did not do it.\n";
  }
  std::cout.flush();
}

nlohmann::json JsonOf(const std::vector<Done>& all) {
  nlohmann::json steps = nlohmann::json::array();
  for (const Done& one : all) {
    nlohmann::json step = {{"line", one.what},
                           {"done", one.answer.done},
                           {"errors", one.answer.errors},
                           {"messages", one.answer.messages},
                           {"probed_mm", one.answer.probed_mm},
                           {"position_mm", one.answer.position_mm},
                           {"machine_s", one.machine_s}};
    steps.push_back(step);
  }
  return {{"steps", steps}};
}

// Everything in turn, up to what is not done; what is done is added to `all`.
void DoAll(LinuxCncHost* host, const LinuxCncAsked& asked, std::vector<Done>* all) {
  const auto is_done = [&](const std::string& what, const auto& act) {
    std::cout << "> " << what << '\n' << std::flush;  // Before it: it may take long.
    LinuxCncAnswer answer = act();
    all->push_back({what, std::move(answer), host->machine_s()});
    Print(all->back());
    return all->back().answer.done;
  };
  if (!asked.is_unhomed && !is_done("home", [&] { return host->Home(); })) return;
  for (const std::string& line : asked.lines) {
    if (!is_done(line, [&] { return host->Mdi(line); })) return;
  }
  if (asked.program.empty()) return;
  is_done(asked.program, [&] {
    return host->Program(fs::path(asked.program).filename().string(),
                         ReadTextFile(asked.program, kLargestData_bytes));
  });
}

void PrintSpeed(double machine_s, double real_s) {
  std::cout << fmt::format(
      "{:.1f} s of the machine's time in {:.1f} s: {:.0f} times as fast\n",
      machine_s,
      real_s,
      machine_s / real_s);
}

int Drive(Board* board, const LinuxCncOptions& options, const LinuxCncAsked& asked) {
  using Now = std::chrono::steady_clock;
  std::vector<Done> all;
  int code = kLost;
  try {
    LinuxCncHost host(board, options);
    const auto start = Now::now();
    const double before_s = host.machine_s();
    DoAll(&host, asked, &all);
    PrintSpeed(host.machine_s() - before_s,
               std::chrono::duration<double>(Now::now() - start).count());
    code = all.back().answer.done ? kPassed : kCheckFailed;
  } catch (const HostLost& lost) {
    if (InterruptRequested()) {
      code = kInterrupted;
    } else {
      std::cerr << "caltwin: " << lost.what() << '\n';
    }
  }
  if (!asked.json.empty()) {
    WriteTextFile(asked.json, JsonOf(all).dump(kJsonIndent) + "\n");
  }
  return code;
}

int LinuxCnc(const LinuxCncAsked& asked) {
  if (asked.lines.empty() && asked.program.empty() && asked.is_unhomed) {
    throw InputError({},
                     "there is nothing for LinuxCNC to do",
                     "-c \"G38.2 Z-5 F60\", or --program FILE");
  }
  const fs::path file =
      FindMachine(asked.twin.machine, "", {.file = asked.twin.machine});
  const ServedKind& kind = ServedToLinuxCnc(file, asked.twin.machine);
  for (const std::string& line : asked.lines) RequireMdiLine(line, "-c");
  if (!asked.program.empty()) {
    RequireText(ReadTextFile(asked.program, kLargestData_bytes), asked.program);
  }
  // Refused now or never.
  for (const std::string& kept : {asked.log, asked.json}) {
    if (!kept.empty()) WriteTextFile(kept, "");
  }
  const auto board = kind.board(file, asked.twin);
  const LinuxCncOptions options{
      .files = FilesOf(asked, kind, file),
      .set = asked.set,
      .probe = {.is_latched = asked.is_latched, .bounce_s = asked.bounce_ms * 1e-3},
      .log = asked.log,
      .patience = std::chrono::milliseconds(std::llround(asked.patience_s * 1e3)),
      .longest_s = asked.longest_s};
  return Drive(board.get(), options, asked);
}

}  // namespace

Action DeclareLinuxCnc(CLI::App* app) {
  auto options = std::make_shared<LinuxCncAsked>();
  options->twin.fidelity = "fast";
  app->add_option("MACHINE", options->twin.machine, "a name or a machine file")
      ->required();
  app->add_option("-c,--mdi",
                  options->lines,
                  "a line of G-code, as typed at MDI; in order, as often as wanted")
      ->allow_extra_args(false);
  app->add_option("--program", options->program, "a .ngc file, run after those");
  app->add_option("--truth",
                  options->twin.truth,
                  "how the machine differs from its drawing and settings");
  app->add_option(
      "--ini",
      options->ini,
      "your INI file, and what lies beside it (they stay as they are); "
      "without it the machine as drawn, as `caltwin new linuxcnc` writes it");
  app->add_option("--set",
                  options->set,
                  "a value of the INI file for this run, SECTION.KEY=VALUE: "
                  "JOINT_0.BACKLASH=0.05")
      ->allow_extra_args(false);
  app->add_flag("--unhomed", options->is_unhomed, "do not home first");
  app->add_flag("--latch",
                options->is_latched,
                "the card holds where the joints stood when the probe closed");
  app->add_option(
         "--bounce",
         options->bounce_ms,
         "so many milliseconds the probe's contact bounces once it has closed; "
         "below a servo period nobody sees it")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  app->add_option("--json", options->json, "write all answers here");
  app->add_option("--log", options->log, "keep what LinuxCNC prints here");
  app->add_option("--fidelity", options->twin.fidelity, "physics or fast")
      ->check(CLI::IsMember({"physics", "fast"}))
      ->capture_default_str();
  app->add_option("--seed", options->twin.seed, "of all chance")->capture_default_str();
  app->add_option("--patience",
                  options->patience_s,
                  "so many seconds LinuxCNC may compute without a servo cycle")
      ->check(CLI::Range(1.0, 86400.0))
      ->capture_default_str();
  app->add_option("--longest",
                  options->longest_s,
                  "so many seconds one line or the program may take, by the machine's "
                  "clock")
      ->check(CLI::Range(1.0, 1e7))
      ->capture_default_str();
  app->footer(
      "The unmodified LinuxCNC homes and probes a machine whose errors it cannot see, "
      "servo cycle by servo cycle, as fast as both compute.\n"
      "Example: caltwin linuxcnc gantry_router --truth hidden.yaml -c \"G0 X100 Y100\" "
      "-c \"G38.2 Z-5 F60\"\n"
      "Exit codes: 1 LinuxCNC refused a line, 3 it was lost.");
  return [options] {
    return LinuxCnc(*options);
  };
}

}  // namespace caltwin
