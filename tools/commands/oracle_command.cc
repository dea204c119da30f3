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

int RunOracle(const OracleAsked& options) {
  DeltaOracle oracle(options.machines, options.seed);
  if (options.program.empty()) {
    AnswerInput(&oracle);
  } else {
    const ChildEnd end =
        ConverseWith({.words = options.program, .patience = std::chrono::hours(24)},
                     [&](std::string_view line) { return oracle.Answer(line); });
    if (end.how == ChildEnd::How::kNotStarted) {
      throw InputError({.file = options.program.front()},
                       "cannot be started: " + ToString(end),
                       "caltwin oracle -- PROGRAM ARGUMENT...");
    }
    const bool has_failed = end.how != ChildEnd::How::kExited || end.code != 0;
    if (has_failed) {
      std::cerr << fmt::format("{} {}\n", options.program.front(), ToString(end));
      if (end.how == ChildEnd::How::kInterrupted) return kInterrupted;
      if (oracle.scores().empty()) return kLost;
    }
  }
  if (oracle.scores().empty()) {
    throw InputError({},
                     "no machine was calibrated",
                     R"(a program says {"ask": "done", "geometry": {...}} for each)");
  }
  if (!options.json.empty()) {
    WriteTextFile(options.json,
                  OracleJson(oracle, options.seed).dump(kJsonIndent) + "\n");
  }
  // Standard output is the program's where none is run.
  (options.program.empty() ? std::cerr : std::cout) << OracleText(oracle, options.seed);
  if (oracle.errors() > 0) {
    std::cerr << fmt::format("{} lines were answered by an error\n", oracle.errors());
  }
  return InterruptRequested() ? kInterrupted : kPassed;
}

}  // namespace

Action DeclareOracle(CLI::App* app) {
  auto options = std::make_shared<OracleAsked>();
  app->add_option("--machines", options->machines, "how many deltas to calibrate")
      ->check(CLI::Range(1, kMostMachines))
      ->capture_default_str();
  app->add_option("--seed", options->seed, "of all chance")->capture_default_str();
  app->add_option(
      "--json", options->json, "writes the score of each machine to a file");
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
