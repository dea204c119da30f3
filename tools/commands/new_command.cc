#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/temporary_folder.h"
#include "sim/base/text_file.h"
#include "sim/controllers/linuxcnc/own_ini.h"
#include "sim/machine/machine.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/import/kinds/printer_of_cfg.h"
#include "sim/measure/import/printer_cfg_adapted.h"
#include "sim/measure/import/printer_cfg_text.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/served.h"
#include "tools/commands/starter.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr const char* kUsualSerial = "/tmp/klipper_host_caltwin";

struct NewAsked {
  std::string name{};
  std::string like = "gantry_router";
  std::string from{};
};

void RefuseIfThere(const fs::path& file,
                   const std::string& hint = "take another name, or move it away") {
  std::error_code error;
  if (!fs::exists(file, error)) return;
  throw InputError({.file = file.string()}, "this file is already there", hint);
}

// A machine that was made of a person's file, read as any is.
template <typename Use>
auto Drawn(const std::string& machine, const NewAsked& options, const Use& use) {
  const TemporaryFolder folder{"caltwin_new"};
  const fs::path file = folder.path() / "machine.yaml";
  WriteTextFile(file, machine);
  try {
    return use(file);
  } catch (const InputError& error) {
    // Lines of a file that nobody has say nothing.
    std::string what = error.what();
    for (auto at = what.find(file.string()); at != what.npos;
         at = what.find(file.string())) {
      what.erase(at, what.find(": ", at) + 2 - at);
    }
    throw InputError({.file = options.from}, "no such machine can be drawn: " + what);
  }
}

void Tell(const std::vector<fs::path>& files, const std::vector<std::string>& changes) {
  for (const fs::path& file : files) std::cout << file.string() << '\n';
  for (const std::string& change : changes) std::cout << "  " << change << '\n';
}

// A person's printer.cfg makes both: the machine, and the same file on its pins.
int NewFromPrinterCfg(const NewAsked& options, const fs::path& file) {
  const std::string whole =
      WithIncluded(ReadTextFile(options.from, kLargestFile_bytes),
                   fs::absolute(fs::path(options.from)).parent_path());
  const std::string text = MachineFileOf(PrinterCfg(whole, options.from), options.name);
  const fs::path config = file.parent_path() / "printer.cfg";
  RefuseIfThere(config);
  const std::string drawn = Drawn(text, options, [&](const fs::path& read) {
    return ServedToKlipper(read, options.name)
        .printer_cfg(ReadAnyMachineFile(read).machine, kUsualSerial);
  });
  const AdaptedConfig adapted = AdaptedToTwin(whole, drawn);
  WriteTextFile(file, text);
  WriteTextFile(config, adapted.text);
  Tell({file, config}, adapted.changes);
  std::cout << fmt::format(
      "Say in hidden.yaml how it is truly built, then:\n"
      "  caltwin klipper {0} --config {1} --truth hidden.yaml -c G28\n",
      options.name,
      config.string());
  return kPassed;
}

// The component that caltwin's HAL file loads.
void WriteComponent(const fs::path& folder) {
  const fs::path component = ShareFolder() / "sim/controllers/linuxcnc/component";
  for (const char* const name : {"caltwin.comp", "page.h", "COPYING"}) {
    WriteTextFile(folder / name, ReadTextFile(component / name, kLargestFile_bytes));
  }
}

// A person's INI file of LinuxCNC likewise, with the tables that it names.
int NewFromIni(const NewAsked& options, const fs::path& file) {
  const std::string ini = ReadTextFile(options.from, kLargestFile_bytes);
  const std::string text = linuxcnc::MachineFileOfIni(ini, options.from, options.name);
  const fs::path folder = file.parent_path() / "linuxcnc";
  RefuseIfThere(folder / "machine.ini");
  const auto drawn = Drawn(text, options, [&](const fs::path& read) {
    return ServedToLinuxCnc(read, options.name)
        .linuxcnc(ReadAnyMachineFile(read).machine);
  });
  linuxcnc::OwnIni own = linuxcnc::WithTwin(ini, drawn);
  WriteTextFile(file, text);
  WriteTextFile(folder / "machine.ini", own.ini);
  WriteTextFile(folder / "machine.hal", own.hal);
  WriteTextFile(folder / "tool.tbl", "T1 P1\n");
  WriteComponent(folder);
  for (const linuxcnc::OwnTable& table : own.tables) {
    const fs::path from = fs::path(options.from).parent_path() / table.from;
    std::error_code error;
    if (fs::is_regular_file(from, error)) {
      WriteTextFile(folder / table.name,
                    table.Raised(ReadTextFile(from, kLargestFile_bytes)));
    } else {
      own.changes.push_back(table.from + " is not there: its joint is without a table");
    }
  }
  Tell({file, folder / "machine.ini", folder / "machine.hal"}, own.changes);
  std::cout << fmt::format(
      "Say in hidden.yaml how it is truly built, then:\n"
      "  caltwin linuxcnc {} --ini {} --truth hidden.yaml -c \"G0 X10\"\n",
      options.name,
      (folder / "machine.ini").string());
  return kPassed;
}

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
  const fs::path file = fs::path("models") / options.name / "machine.yaml";
  RefuseIfThere(file);
  if (options.from.ends_with(".ini")) return NewFromIni(options, file);
  if (!options.from.empty()) return NewFromPrinterCfg(options, file);
  const fs::path like =
      FindMachine(options.like, "", {.file = "--like " + options.like});
  const Machine machine = ReadMachine(like);
  WriteTextFile(
      file,
      machine.kind->axes_are_drives() && !machine.own.has_value()
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
  std::string serial = kUsualSerial;
};

int NewKlipper(const NewKlipperAsked& options) {
  const fs::path file = FindMachine(options.machine, "", {.file = options.machine});
  const ServedKind& kind = ServedToKlipper(file, options.machine);
  RefuseIfThere(options.out,
                "a host keeps what it calibrated in it: take another name, or move it "
                "away");
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

struct NewLinuxCncAsked {
  std::string machine{};
  std::string out{};
  std::string page = "caltwin";
};

// A folder of LinuxCNC's configuration, with the component that it loads.
int NewLinuxCnc(const NewLinuxCncAsked& options) {
  const fs::path file = FindMachine(options.machine, "", {.file = options.machine});
  const ServedKind& kind = ServedToLinuxCnc(file, options.machine);
  const fs::path folder = options.out;
  RefuseIfThere(folder / "machine.ini", "take another folder, or move it away");
  const Machine machine = ReadAnyMachineFile(file).machine;
  for (const auto& [name, text] :
       linuxcnc::ConfigFiles(kind.linuxcnc(machine), "axis", options.page)) {
    WriteTextFile(folder / name, text);
  }
  WriteComponent(folder);
  std::cout << fmt::format(
      "{0}/machine.ini\nOnce: cd {0} && sudo halcompile --install caltwin.comp\n"
      "The machine: caltwin serve --machine {1} --fidelity fast --linuxcnc {2}\n"
      "LinuxCNC: linuxcnc {0}/machine.ini\n"
      "By itself, homed and as fast as it goes: caltwin linuxcnc {1} --ini "
      "{0}/machine.ini -c \"G0 X10\"\n",
      folder.string(),
      options.machine,
      options.page);
  return kPassed;
}

CLI::App* DeclareNewLinuxCnc(CLI::App* app, NewLinuxCncAsked* options) {
  CLI::App* const linuxcnc = app->add_subcommand(
      "linuxcnc", "the INI and HAL files of a machine as drawn, for LinuxCNC");
  linuxcnc->add_option("MACHINE", options->machine, "a name or a machine file")
      ->required();
  linuxcnc->add_option("--out", options->out, "the folder to write them to")
      ->required();
  linuxcnc
      ->add_option(
          "--page", options->page, "what `caltwin serve --linuxcnc` will be given")
      ->capture_default_str();
  return linuxcnc;
}

}  // namespace

Action DeclareNew(CLI::App* app) {
  auto options = std::make_shared<NewAsked>();
  auto klipper_options = std::make_shared<NewKlipperAsked>();
  CLI::App* machine =
      app->add_subcommand("machine", "a commented models/NAME/machine.yaml");
  machine->add_option("NAME", options->name, "letters, digits, _ and -")->required();
  CLI::Option* const like =
      machine
          ->add_option(
              "--like", options->like, "the machine whose sizes it starts with")
          ->capture_default_str();
  machine
      ->add_option("--from",
                   options->from,
                   "your own printer.cfg of Klipper, or .ini of LinuxCNC: its sizes, "
                   "and beside the machine file the same with the twin's pins")
      ->excludes(like);
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
  auto linuxcnc_options = std::make_shared<NewLinuxCncAsked>();
  const CLI::App* linuxcnc = DeclareNewLinuxCnc(app, linuxcnc_options.get());
  return [options, klipper_options, klipper, linuxcnc_options, linuxcnc] {
    if (linuxcnc->parsed()) return NewLinuxCnc(*linuxcnc_options);
    return klipper->parsed() ? NewKlipper(*klipper_options) : NewMachine(*options);
  };
}

}  // namespace caltwin
