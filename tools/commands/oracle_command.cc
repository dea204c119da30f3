#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/child_process.h"
#include "scenarios/interrupt.h"
#include "scenarios/kinds/delta_oracle.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

constexpr int kMostMachines = 10'000;

struct OracleAsked {
  int machines = 150;
  std::uint64_t seed = 1;
  std::string json{};
  std::vector<std::string> program{};
};

// The whole conversation on our own input and output.
void AnswerInput(DeltaOracle* oracle) {
  for (std::string line; !InterruptRequested() && std::getline(std::cin, line);) {
    if (!line.empty()) std::cout << oracle->Answer(line) << std::flush;
  }
}

// Whether the program came to its end by itself.
bool AnswerProgram(const OracleAsked& options, DeltaOracle* oracle) {
  const ChildEnd end =
      ConverseWith({.words = options.program, .patience = std::chrono::hours(24)},
                   [&](std::string_view line) { return oracle->Answer(line); });
  if (end.how == ChildEnd::How::kNotStarted) {
    throw InputError({.file = options.program.front()},
                     ToString(end),
                     "caltwin oracle -- PROGRAM ARGUMENT...");
  }
  if (end.how == ChildEnd::How::kExited && end.code == 0) return true;
  std::cerr << fmt::format("{} {}\n", options.program.front(), ToString(end));
  return false;
}

void Tell(const OracleAsked& options, const DeltaOracle& oracle) {
  const std::string dump = OracleJson(oracle, options.seed).dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << dump;
  } else {
    if (!options.json.empty()) WriteTextFile(options.json, dump);
    // Standard output is the conversation's where no program is run.
    (options.program.empty() ? std::cerr : std::cout)
        << OracleText(oracle, options.seed);
  }
  if (oracle.errors() == 0) return;
  std::cerr << fmt::format("{} lines were answered by an error\n", oracle.errors());
}

int RunOracle(const OracleAsked& options) {
  if (options.program.empty() && options.json == "-") {
    throw InputError({.file = "--json"},
                     "standard output is the conversation's where no program is run",
                     "--json FILE");
  }
  DeltaOracle oracle(options.machines, options.seed);
  bool has_ended = true;
  if (options.program.empty()) {
    AnswerInput(&oracle);
  } else {
    has_ended = AnswerProgram(options, &oracle);
  }
  if (oracle.scores().empty()) {
    if (InterruptRequested()) return kInterrupted;
    if (!has_ended) return kLost;
    throw InputError({},
                     "no machine was calibrated",
                     R"(a program says {"ask": "done", "geometry": {...}} for each)");
  }
  Tell(options, oracle);
  if (InterruptRequested()) return kInterrupted;
  if (!has_ended) return kLost;
  const bool are_all = static_cast<int>(oracle.scores().size()) == oracle.machines();
  return are_all ? kPassed : kCheckFailed;
}

}  // namespace

Action DeclareOracle(CLI::App* app) {
  auto options = std::make_shared<OracleAsked>();
  app->add_option("--machines", options->machines, "how many deltas to calibrate")
      ->check(CLI::Range(1, kMostMachines))
      ->capture_default_str();
  app->add_option("--seed", options->seed, "of all chance")->capture_default_str();
  app->add_option("--json",
                  options->json,
                  "writes the score of each machine to a file; - for stdout");
  app->add_option("program",
                  options->program,
                  "that calibrates them, and its arguments, behind --");
  app->footer(
      "The program writes one JSON object a line and reads the answer: "
      "{\"ask\": \"machine\"}, {\"ask\": \"probe\", \"x\": 0, \"y\": 50}, {\"ask\": "
      "\"set\", \"geometry\": {...}}, {\"ask\": \"done\", \"geometry\": {...}}. "
      "Without a "
      "program the conversation is on standard input and output.\n"
      "Try: caltwin oracle -- python3 examples/oracle_delta.py");
  return [options] {
    return RunOracle(*options);
  };
}

}  // namespace caltwin
