#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/interrupt.h"
#include "scenarios/klipper/host.h"
#include "scenarios/klipper/host_process.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/printer_cfg.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/served.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

struct KlipperAsked {
  TwinOptions twin{};
  std::vector<std::string> lines{};
  std::string gcode{}, config{}, host{}, out{}, json{}, log{};
  double patience_s = 120;
};

/// What was said, and where it ended.
struct Said {
  std::string line{};
  HostAnswer answer{};
  double printer_s = 0;  ///< When it was done, by the printer's clock.
};

// Lines of a file; `;` begins a comment.
std::vector<std::string> LinesIn(const std::string& text) {
  std::vector<std::string> lines;
  for (const TextLine& line : LinesOf(text)) {
    std::string_view said = line.text.substr(0, line.text.find(';'));
    said = said.substr(0, said.find_last_not_of(" \t") + 1);
    if (!said.empty()) lines.emplace_back(said);
  }
  return lines;
}

std::vector<std::string> LinesToSay(const KlipperAsked& asked) {
  std::vector<std::string> lines = asked.lines;
  if (!asked.gcode.empty()) {
    const auto more = LinesIn(ReadTextFile(asked.gcode, kLargestFile_bytes));
    lines.insert(lines.end(), more.begin(), more.end());
  }
  if (lines.empty()) {
    throw InputError({},
                     "there is nothing for the host to do",
                     "-c G28 -c DELTA_CALIBRATE -c SAVE_CONFIG, or --gcode FILE");
  }
  return lines;
}

void Print(const Said& said) {
  std::cout << "> " << said.line << '\n';
  for (const std::string& line : said.answer.lines) std::cout << line << '\n';
  if (said.answer.refusal) {
    std::cout << "The host stopped here: " << *said.answer.refusal << '\n';
  }
  if (said.answer.shut_down) {
    std::cout << "The microcontroller has shut down: " << *said.answer.shut_down
              << '\n';
  }
  if (said.answer.has_restarted) std::cout << "The host has started anew.\n";
  std::cout.flush();
}

void PrintSaved(const std::vector<PrinterCfg::Saved>& saved) {
  if (saved.empty()) {
    std::cout << "Nothing was saved in printer.cfg.\n";
    return;
  }
  std::cout << "Saved in printer.cfg:\n";
  for (const PrinterCfg::Saved& one : saved) {
    const bool is_long = one.value.find('\n') != std::string::npos;
    std::cout << fmt::format(
        "  [{}] {} ={}{}\n", one.section, one.key, is_long ? "\n    " : " ", one.value);
  }
}

std::vector<PrinterCfg::Saved> SavedBy(const KlipperHost& host) {
  return PrinterCfg(host.Config(), "printer.cfg").AllSaved();
}

nlohmann::json JsonOf(const std::vector<Said>& all, const KlipperHost& host) {
  nlohmann::json steps = nlohmann::json::array();
  for (const Said& one : all) {
    nlohmann::json step = {{"line", one.line},
                           {"printed", one.answer.lines},
                           {"printer_s", one.printer_s}};
    if (one.answer.refusal) step["refusal"] = *one.answer.refusal;
    if (one.answer.shut_down) step["shut_down"] = *one.answer.shut_down;
    if (one.answer.has_restarted) step["has_restarted"] = true;
    steps.push_back(step);
  }
  nlohmann::json saved = nlohmann::json::array();
  for (const PrinterCfg::Saved& one : SavedBy(host)) {
    saved.push_back(
        {{"section", one.section}, {"option", one.key}, {"value", one.value}});
  }
  return {{"steps", steps}, {"saved", saved}, {"printer_s", host.printer_s()}};
}

bool IsFine(const HostAnswer& answer) {
  return !answer.refusal && !answer.shut_down;
}

int SayAll(KlipperHost* host, const KlipperAsked& asked) {
  using Now = std::chrono::steady_clock;
  const auto start = Now::now();
  const double before_s = host->printer_s();
  std::vector<Said> all;
  for (const std::string& line : LinesToSay(asked)) {
    HostAnswer answer = host->Say(line);
    all.push_back({line, std::move(answer), host->printer_s()});
    Print(all.back());
    if (!IsFine(all.back().answer)) break;
  }
  const double real_s = std::chrono::duration<double>(Now::now() - start).count();
  const double printer_s = host->printer_s() - before_s;
  PrintSaved(SavedBy(*host));
  std::cout << fmt::format(
      "{:.1f} s of the printer's time in {:.1f} s: {:.0f} times as fast\n",
      printer_s,
      real_s,
      printer_s / real_s);
  if (!asked.out.empty()) WriteTextFile(asked.out, host->Config());
  if (!asked.json.empty()) {
    WriteTextFile(asked.json, JsonOf(all, *host).dump(kJsonIndent) + "\n");
  }
  return IsFine(all.back().answer) ? kPassed : kCheckFailed;
}

int Klipper(const KlipperAsked& asked) {
  const fs::path file =
      FindMachine(asked.twin.machine, "", {.file = asked.twin.machine});
  const ServedKind& kind = ServedToKlipper(file, asked.twin.machine);
  LinesToSay(asked);
  if (!asked.log.empty()) WriteTextFile(asked.log, "");  // Refused now or never.
  const auto board = kind.board(file, asked.twin);
  const bool has_config = !asked.config.empty();
  const KlipperHostOptions options{
      .program = HostProgram(asked.host),
      .config = has_config ? ReadTextFile(asked.config, kLargestFile_bytes)
                           : kind.printer_cfg(ReadAnyMachineFile(file).machine, "-"),
      .name = has_config ? asked.config : "printer.cfg",
      .beside = has_config ? fs::absolute(asked.config).parent_path() : fs::path(),
      .log = asked.log,
      .patience = std::chrono::milliseconds(std::llround(asked.patience_s * 1e3))};
  try {
    KlipperHost host(board.get(), options);
    return SayAll(&host, asked);
  } catch (const HostLost& lost) {
    if (InterruptRequested()) return kInterrupted;
    std::cerr << "caltwin: " << lost.what() << '\n';
    return kLost;
  }
}

}  // namespace

Action DeclareKlipper(CLI::App* app) {
  auto options = std::make_shared<KlipperAsked>();
  app->add_option("MACHINE", options->twin.machine, "a name or a machine file")
      ->required();
  app->add_option("-c,--say",
                  options->lines,
                  "a line of G-code for the host; in order, as often as wanted")
      ->allow_extra_args(false);
  app->add_option("--gcode", options->gcode, "a file of such lines, said after those");
  app->add_option("--truth",
                  options->twin.truth,
                  "how the machine differs from its drawing and settings");
  app->add_option(
      "--config",
      options->config,
      "your printer.cfg (it stays as it is); without it the machine as drawn, "
      "as `caltwin new klipper` writes it");
  app->add_option("--out", options->out, "write what printer.cfg is at the end here");
  app->add_option("--json", options->json, "write all answers and what was saved here");
  app->add_option("--log", options->log, "keep the host's own log here");
  app->add_option("--fidelity", options->twin.fidelity, "physics or fast")
      ->check(CLI::IsMember({"physics", "fast"}))
      ->capture_default_str();
  app->add_option("--seed", options->twin.seed, "of all chance")->capture_default_str();
  app->add_option(
      "--host",
      options->host,
      "the host program: kalico, or Klipper's (default: $CALTWIN_KLIPPER_HOST, "
      "what tools/setup.sh --controllers installed, kalico in the PATH)");
  app->add_option("--patience",
                  options->patience_s,
                  "so many seconds the host may compute without asking for time")
      ->check(CLI::Range(1.0, 86400.0))
      ->capture_default_str();
  app->footer(
      "The unmodified host homes, probes and calibrates a machine whose errors it "
      "cannot "
      "see; its time is simulated, so it runs as fast as both sides compute, and the "
      "same "
      "lines give the same result.\nExample: caltwin klipper delta_printer --truth "
      "hidden.yaml -c G28 -c DELTA_CALIBRATE -c SAVE_CONFIG\nExit codes: 1 the host "
      "refused "
      "a line, 3 the host was lost.");
  return [options] {
    return Klipper(*options);
  };
}

}  // namespace caltwin
