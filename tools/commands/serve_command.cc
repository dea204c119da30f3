#include <exception>
#include <iostream>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "tools/commands/api/web_service.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/served.h"
#include "tools/commands/serve/paced_link.h"
#include "tools/commands/serve/serve.h"
#include "tools/commands/serve/serve_klipper.h"
#include "tools/commands/serve/serve_linuxcnc.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

constexpr int kLargestPort = 65535;
constexpr double kSlowest = 0.01, kFastest = 10'000;

struct ServeAsked {
  TwinOptions twin{};
  std::string bench{};
  std::optional<int> port{};
  std::optional<int> http{};
  WebOptions web{};
  std::string pty{};
  std::string klipper{};
  std::string linuxcnc{};
  std::string dialect{};  ///< Empty: as the machine's controller speaks.
  std::optional<double> speed{};
};

// In one piece, from whatever thread.
void Announce(const std::string& text) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  std::cout << text + "\n" << std::flush;
}

void OnPort(const ServeAsked& options, const OpenPort& open_port) {
  ServeTcp(open_port, *options.port, &InterruptFlag(), [](int port) {
    Announce(fmt::format("listening on 127.0.0.1:{}", port));
  });
}

void OnPty(const ServeAsked& options, const OpenPort& open_port) {
  ServePty(open_port, options.pty, &InterruptFlag(), [&] {
    Announce(fmt::format("terminal at {}", options.pty));
  });
}

// Both at once, the terminal in a thread of its own; where one cannot be had the other
// ends too, and the fault is told.
void OnBoth(const ServeAsked& options, const OpenPort& open_port) {
  std::exception_ptr fault;
  std::thread terminal([&] {
    try {
      OnPty(options, open_port);
    } catch (const InputError&) {
      fault = std::current_exception();
      RequestInterrupt();
    }
  });
  try {
    OnPort(options, open_port);
  } catch (const InputError&) {
    fault = std::current_exception();
    RequestInterrupt();
  }
  terminal.join();
  if (fault) std::rethrow_exception(fault);
}

int Listen(const ServeAsked& options, const OpenPort& open_port) {
  if (options.port && !options.pty.empty()) {
    OnBoth(options, open_port);
  } else if (options.port) {
    OnPort(options, open_port);
  } else {
    OnPty(options, open_port);
  }
  return InterruptRequested() ? kInterrupted : kPassed;
}

// Pages and REST: a machine of its own, led by whoever sits at the page.
int ServeWeb(const ServeAsked& asked) {
  if (asked.port || !asked.pty.empty()) {
    throw InputError({.file = "--http"},
                     "the machine of the pages is not on a wire for others beside it",
                     "start a second caltwin serve with --tcp or --pty");
  }
  WebOptions options = asked.web;
  options.port = *asked.http;
  options.twin = asked.twin;
  WebService service(options, &InterruptFlag());
  for (const std::string& note : service.Notes()) Announce(note);
  service.Serve([](const std::string& url) {
    Announce(fmt::format("open {} in a browser; Ctrl-C ends", url));
  });
  return InterruptRequested() ? kInterrupted : kPassed;
}

// A real controller drives the machine, and nobody else.
void RequireAlone(const ServeAsked& options,
                  const std::string& option,
                  std::string_view controller) {
  const bool has_both = !options.klipper.empty() && !options.linuxcnc.empty();
  if (!options.port && options.pty.empty() && !options.http && options.bench.empty() &&
      options.dialect.empty() && !has_both) {
    return;
  }
  throw InputError(
      {.file = option},
      fmt::format("{} alone drives the machine, and nobody at its bench", controller),
      "leave --tcp, --pty, --http, --bench and --dialect away, and take one of "
      "--klipper and --linuxcnc");
}

// The twin as the card with LinuxCNC's step generators.
int ServeToLinuxCnc(const ServeAsked& options) {
  RequireAlone(options, "--linuxcnc", "LinuxCNC");
  const std::filesystem::path machine =
      FindMachine(options.twin.machine, "", {.file = options.twin.machine});
  const ServedKind& kind = ServedToLinuxCnc(machine, "--linuxcnc");
  const auto board = kind.board(machine, options.twin);
  ServeLinuxCnc(board.get(), options.linuxcnc, &InterruptFlag(), [&] {
    Announce(fmt::format("{}, {}: for LinuxCNC, loadrt caltwin page={}; Ctrl-C ends",
                         options.twin.machine,
                         options.twin.fidelity,
                         options.linuxcnc));
  });
  return InterruptRequested() ? kInterrupted : kPassed;
}

// The twin as a microcontroller: its host is another program.
int ServeToKlipper(const ServeAsked& options) {
  RequireAlone(options, "--klipper", "Klipper's host");
  const std::filesystem::path machine =
      FindMachine(options.twin.machine, "", {.file = options.twin.machine});
  const ServedKind& kind = ServedToKlipper(machine, "--klipper");
  const auto board = kind.board(machine, options.twin);
  ServeKlipper(
      board.get(),
      options.klipper,
      &InterruptFlag(),
      [&] {
        Announce(fmt::format("{}, {}: a Klipper microcontroller at {}; Ctrl-C ends",
                             options.twin.machine,
                             options.twin.fidelity,
                             options.klipper));
      },
      [](std::string_view why) { Announce(fmt::format("shut down: {}", why)); });
  return InterruptRequested() ? kInterrupted : kPassed;
}

// Seconds of the machine in one of ours; infinite where nobody asks for any.
double SpeedOf(const ServeAsked& options, const ServedDialect& dialect) {
  if (!options.speed) return std::numeric_limits<double>::infinity();
  if (dialect.keeps_pace) return *options.speed;
  throw InputError(
      {.file = "--speed"},
      fmt::format("with --dialect {} each move is over at once", dialect.name),
      "leave it away; a gantry, a CoreXY and a delta keep a pace");
}

int Serve(ServeAsked options) {
  const bool keeps_own_time =
      options.http || !options.klipper.empty() || !options.linuxcnc.empty();
  if (keeps_own_time && options.speed) {
    throw InputError({.file = "--speed"},
                     "is of a machine on --tcp or --pty: the pages' machine is never "
                     "waited for, and real controllers bring their own time",
                     "leave it away");
  }
  if (options.http && !options.dialect.empty()) {
    throw InputError({.file = "--dialect"},
                     "is of a machine on --tcp or --pty: pages and REST speak the "
                     "machine's own",
                     "leave it away");
  }
  if (!options.klipper.empty()) return ServeToKlipper(options);
  if (!options.linuxcnc.empty()) return ServeToLinuxCnc(options);
  if (!options.port && options.pty.empty() && !options.http) {
    throw InputError({},
                     "serve needs to know where",
                     "--http PORT (pages and REST), --tcp PORT (0: any free one), "
                     "--pty PATH, --klipper PATH, or --linuxcnc NAME");
  }
  if (!options.bench.empty()) ReadBenchFile(options.bench, &options.twin);
  if (options.http) return ServeWeb(options);
  const std::filesystem::path machine =
      FindMachine(options.twin.machine, "", {.file = options.twin.machine});
  const ServedKind& kind = ServedKindOf(machine);
  const ServedDialect& dialect = DialectOf(kind, options.dialect);
  const double speed = SpeedOf(options, dialect);
  const Served served = dialect.make(machine, {options.twin, options.bench, speed});
  Announce(served.about + "; Ctrl-C ends");
  if (served.open_port) return Listen(options, served.open_port);
  PacedLink paced(served.link, served.time_s, speed);
  SharedLink shared(&paced);
  return Listen(options, PortsOf(&shared, dialect.says_busy));
}

void DeclareWeb(CLI::App* app, ServeAsked* options) {
  CLI::Option* const http =
      app->add_option(
             "--http",
             options->http,
             "serve pages and REST on this port; 0: any. Without --machine two "
             "machines to practise on")
          ->check(CLI::Range(0, kLargestPort));
  app->add_option("--listen",
                  options->web.address,
                  "with --http: the address of this computer to listen on; one that "
                  "others reach needs --token-file")
      ->capture_default_str()
      ->needs(http);
  app->add_option("--token-file",
                  options->web.token_file,
                  "with --http: a file with the secret that clients have to say")
      ->needs(http);
  app->add_option("--state",
                  options->web.state,
                  "with --http: the folder that keeps what was found (default "
                  "~/.local/state/caltwin)")
      ->needs(http);
  app->add_option("--link",
                  options->web.link,
                  "with --http: a real machine in place of the twin, "
                  "serial:/dev/ttyACM0?baud=115200 or tcp:host:port; needs --machine")
      ->needs(http);
}

}  // namespace

Action DeclareServe(CLI::App* app) {
  auto options = std::make_shared<ServeAsked>();
  const CLI::Option* const machine =
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
  app->add_option(
      "--klipper",
      options->klipper,
      "be a Klipper microcontroller on a pseudo-terminal of this name, the "
      "`serial:` of its host (`caltwin new klipper` writes its printer.cfg)");
  app->add_option("--linuxcnc",
                  options->linuxcnc,
                  "be the machine of a LinuxCNC whose component has this name for its "
                  "page (`caltwin new linuxcnc` writes its configuration)");
  DeclareWeb(app, options.get());
  app->add_option("--fidelity", options->twin.fidelity, "physics or fast")
      ->check(CLI::IsMember({"physics", "fast"}))
      ->capture_default_str();
  app->add_option("--seed", options->twin.seed, "of all chance")->capture_default_str();
  app->add_option(
         "--dialect",
         options->dialect,
         "the controller's: rrf or grbl of a gantry, rrf of a CoreXY or a "
         "triple-Z printer, marlin of a delta, klipper of a z_station, motor of "
         "a motor stage")
      ->check(CLI::IsMember({"rrf", "grbl", "marlin", "klipper", "motor"}));
  app->add_option("--speed",
                  options->speed,
                  "seconds of the machine in one of ours, 1 as a real one (gantry, "
                  "CoreXY, delta); without it a move is over as soon as it is computed")
      ->check(CLI::Range(kSlowest, kFastest));
  app->footer(
      "A browser shows the pages of --http; a terminal program or G-code sender "
      "connects "
      "to --tcp or --pty as to a real machine. Only this computer can, unless --listen "
      "says otherwise. Ctrl-C ends it.");
  return [options, machine] {
    options->web.has_machine = machine->count() > 0;
    if (!options->web.link.empty() && !options->web.has_machine) {
      throw InputError(
          {.file = "--link"}, "which machine is at its end?", "--machine NAME or FILE");
    }
    return Serve(*options);
  };
}

}  // namespace caltwin
