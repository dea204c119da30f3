#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/machine/machine.h"
#include "sim/machine/machine_kind.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/served.h"
#include "tools/commands/starter.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

struct NewAsked {
  std::string name{};
  std::string like = "gantry_router";
};

int NewMachine(const NewAsked& options) {
  const bool is_plain =
      !options.name.empty() &&
      options.name.find_first_not_of(
          "abcdefghijklmnopqrstuvwxyz"
          "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") == std::string::npos;
  if (!is_plain) {
    throw InputError({},
                     fmt::format("'{}' is no name for a machine", options.name),
                     "letters, digits, _ and - only: it becomes a folder in models/");
  }
  const fs::path like =
      FindMachine(options.like, "", {.file = "--like " + options.like});
  const fs::path file = fs::path("models") / options.name / "machine.yaml";
  std::error_code error;
  if (fs::exists(file, error)) {
    throw InputError({.file = file.string()},
                     "this file is already there",
                     "take another name, or move it away");
  }
  const Machine machine = ReadMachine(like);
  WriteTextFile(
      file,
      machine.kind->axes_are_drives()
          ? StarterText(machine, options.name)
          : StarterLike(ReadTextFile(like, kLargestFile_bytes), options.name));
  std::cout << fmt::format(
      "{}\nFill in your own sizes, then: caltwin validate {}\nA scenario uses it as "
      "`machine: {}`.\n",
      file.string(),
      file.string(),
      options.name);
  return kPassed;
}

struct NewKlipperAsked {
  std::string machine{};
  std::string out{};
  std::string serial = "/tmp/klipper_host_caltwin";
};

int NewKlipper(const NewKlipperAsked& options) {
  const fs::path file = FindMachine(options.machine, "", {.file = options.machine});
  const ServedKind& kind = ServedToKlipper(file, options.machine);
  std::error_code error;
  if (fs::exists(options.out, error)) {
    throw InputError(
        {.file = options.out},
        "this file is already there",
        "a host keeps what it calibrated in it: take another name, or move "
        "it away");
  }
  WriteTextFile(options.out,
                kind.printer_cfg(ReadAnyMachineFile(file).machine, options.serial));
  std::cout << fmt::format(
      "{}\nThe machine: caltwin serve --machine {} --klipper {}\nIts host: kalico {}, "
      "or "
      "klippy of Klipper.\n",
      options.out,
      options.machine,
      options.serial,
      options.out);
  return kPassed;
}

}  // namespace

Action DeclareNew(CLI::App* app) {
  auto options = std::make_shared<NewAsked>();
  auto klipper_options = std::make_shared<NewKlipperAsked>();
  CLI::App* machine =
      app->add_subcommand("machine", "a commented models/NAME/machine.yaml");
  machine->add_option("NAME", options->name, "letters, digits, _ and -")->required();
  machine->add_option("--like", options->like, "the machine whose sizes it starts with")
      ->capture_default_str();
  CLI::App* klipper = app->add_subcommand(
      "klipper", "the printer.cfg of a machine as drawn, for Klipper's host");
  klipper->add_option("MACHINE", klipper_options->machine, "a name or a machine file")
      ->required();
  klipper->add_option("--out", klipper_options->out, "the file to write")->required();
  klipper
      ->add_option(
          "--serial",
          klipper_options->serial,
          "what `caltwin serve --klipper` is given; a host takes a path that "
          "begins with /tmp/klipper_host_ as it is, any other for a serial port")
      ->capture_default_str();
  app->require_subcommand(1);
  return [options, klipper_options, klipper] {
    return klipper->parsed() ? NewKlipper(*klipper_options) : NewMachine(*options);
  };
}

}  // namespace caltwin
