#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "scenarios/kinds/delta_g33.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/simulated_printer.h"
#include "tools/commands/kinds/simulated_stage.h"
#include "tools/commands/kinds/simulated_station.h"
#include "tools/commands/serve/serve.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

constexpr int kLargestPort = 65535;

struct Options {
  TwinOptions twin{};
  std::string bench{};
  std::optional<int> port{};
  std::string pty{};
  std::string dialect{};  ///< Empty: as the machine's controller speaks.
};

void Announce(const std::string& text) {
  std::cout << text << std::endl;
}

void OnPort(const Options& options, Link* link) {
  ServeTcp(link, *options.port, &InterruptFlag(), [](int port) {
    Announce(fmt::format("listening on 127.0.0.1:{}", port));
  });
}

void OnPty(const Options& options, Link* link) {
  ServePty(link, options.pty, &InterruptFlag(), [&] {
    Announce(fmt::format("terminal at {}", options.pty));
  });
}

// Both at once, the terminal in a thread of its own; where one cannot be had the other
// ends too, and the fault is told.
void OnBoth(const Options& options, Link* link) {
  SharedLink shared(link);
  std::exception_ptr fault;
  std::thread terminal([&] {
    try {
      OnPty(options, &shared);
    } catch (const InputError&) {
      fault = std::current_exception();
      RequestInterrupt();
    }
  });
  try {
    OnPort(options, &shared);
  } catch (const InputError&) {
    fault = std::current_exception();
    RequestInterrupt();
  }
  terminal.join();
  if (fault) std::rethrow_exception(fault);
}

void RequireDialect(const Options& options, const std::string& spoken) {
  if (options.dialect.empty() || options.dialect == spoken) return;
  throw InputError(
      {.file = "--dialect"},
      fmt::format("'{}' is not what this machine's controller speaks", options.dialect),
      fmt::format("it speaks {}: leave the option away", spoken));
}

int Listen(const Options& options, Link* link) {
  if (options.port && !options.pty.empty()) {
    OnBoth(options, link);
  } else if (options.port) {
    OnPort(options, link);
  } else {
    OnPty(options, link);
  }
  return InterruptRequested() ? kInterrupted : kPassed;
}

int ServeDelta(const Options& options, const MachineFile& file) {
  RequireDialect(options, "marlin");
  if (!options.twin.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a delta's bench has no artefacts",
                     "it knows instruments: probe and calliper");
  }
  DeltaTwin twin(MakeDeltaTwinConfig(file, options.twin));
  twin.SetG33(MarlinG33(G33Variant::kCorrected, DeltaOf(file.machine).print_radius_mm));
  Announce(fmt::format("{}, {}, Marlin's dialect; Ctrl-C ends",
                       file.machine.name,
                       ToString(twin.config().fidelity)));
  return Listen(options, &twin.link());
}

int ServePrinter(const Options& options) {
  RequireDialect(options, "rrf");
  if (!options.twin.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a printer's bench has no artefacts",
                     "it knows instruments: probe");
  }
  SimulatedPrinter printer(options.twin);
  Announce(fmt::format("{}, {}, RepRapFirmware's dialect; Ctrl-C ends",
                       printer.machine().name,
                       options.twin.fidelity));
  return Listen(options, &printer.link());
}

int ServeStation(const Options& options) {
  RequireDialect(options, "klipper");
  if (!options.bench.empty()) {
    throw InputError({.file = options.bench}, "a printer's station has no bench");
  }
  SimulatedStation station(options.twin);
  Announce(fmt::format("z_station, {}, Klipper's z_calibration; Ctrl-C ends",
                       options.twin.fidelity));
  return Listen(options, &station.link());
}

int ServeMotors(const Options& options, const std::filesystem::path& machine) {
  RequireDialect(options, "motor");
  if (!options.bench.empty()) {
    throw InputError({.file = options.bench},
                     "a motor stage on a wire has no bench",
                     "nobody at the other end reads its gauges");
  }
  const MotorStageDrawing drawing = ReadMotorStage(machine);
  SimulatedStage stage(drawing, options.twin, /*sigma_unit=*/0);
  Announce(fmt::format("{}, {}, the dialect of docs/motor-axes.md; Ctrl-C ends",
                       drawing.name,
                       options.twin.fidelity));
  return Listen(options, &stage.link());
}

int Serve(Options options) {
  if (!options.port && options.pty.empty()) {
    throw InputError({},
                     "serve needs to know where",
                     "--tcp PORT (0: any free one), --pty PATH, or both");
  }
  if (!options.bench.empty()) ReadBenchFile(options.bench, &options.twin);
  const std::filesystem::path machine =
      FindMachine(options.twin.machine, "", {.file = options.twin.machine});
  if (IsMotorStage(machine)) return ServeMotors(options, machine);
  const MachineFile file = ReadAnyMachineFile(machine);
  if (file.machine.kind == DeltaKind()) return ServeDelta(options, file);
  if (file.machine.kind == TripleZKind()) return ServePrinter(options);
  if (file.machine.kind == ZStationKind()) return ServeStation(options);
  RequireDialect(options, "rrf");
  Twin twin(MakeTwinConfig(options.twin));
  Announce(fmt::format("{}, {}, RepRapFirmware's dialect; Ctrl-C ends",
                       twin.config().machine.name,
                       ToString(twin.config().fidelity)));
  return Listen(options, &twin.link());
}

}  // namespace

Action DeclareServe(CLI::App* app) {
  auto options = std::make_shared<Options>();
  app->add_option("--machine", options->twin.machine, "a name or a machine file")
      ->capture_default_str();
  app->add_option(
      "--truth", options->twin.truth, "how it differs from its drawing and settings");
  app->add_option("--bench",
                  options->bench,
                  "a file with `artefacts` and `instruments`; without it the 1-2-3 "
                  "block lies in the middle of the table, 76.2 mm along x");
  app->add_option("--tcp", options->port, "listen on this port of 127.0.0.1; 0: any")
      ->check(CLI::Range(0, kLargestPort));
  app->add_option("--pty", options->pty, "make a pseudo-terminal of this name");
  app->add_option("--fidelity", options->twin.fidelity, "physics or fast")
      ->check(CLI::IsMember({"physics", "fast"}))
      ->capture_default_str();
  app->add_option("--seed", options->twin.seed, "of all chance")->capture_default_str();
  app->add_option(
         "--dialect",
         options->dialect,
         "the controller's: rrf of a gantry or a triple-Z printer, marlin of a "
         "delta, klipper of a z_station, motor of a motor stage")
      ->check(CLI::IsMember({"rrf", "marlin", "klipper", "motor"}));
  app->footer(
      "A terminal program or G-code sender connects as to a real machine. Only this "
      "computer can. Ctrl-C ends it.");
  return [options] {
    return Serve(*options);
  };
}

}  // namespace caltwin
