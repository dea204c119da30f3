#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/controllers/board.h"
#include "sim/controllers/linuxcnc/config.h"
#include "sim/link/link.h"
#include "sim/machine/machine.h"
#include "tools/commands/serve/port.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A simulated machine with its controller, on a wire: a link, or ports of its own.
struct Served {
  std::string about{};  ///< Its name, its fidelity and what its controller speaks.
  std::shared_ptr<void> machine{};
  Link* link = nullptr;
  /// Of a link: the machine's own time; empty: it knows none.
  std::function<double()> time_s{};
  OpenPort open_port{};
};

/// What somebody asks to be served.
struct ServeOptions {
  TwinOptions twin{};   ///< How the machine was built.
  std::string bench{};  ///< The file that `twin` has instruments and artefacts of.
  /// Seconds of the machine in one of ours.
  double speed = std::numeric_limits<double>::infinity();
};

/// A language that the controllers of a kind can speak.
struct ServedDialect {
  std::string_view name;  ///< `--dialect`
  /// The machine of that file. Throws InputError.
  Served (*make)(const std::filesystem::path& machine, const ServeOptions& options);
  bool keeps_pace = false;  ///< It knows `--speed`.
  bool says_busy = false;   ///< While a line takes long, as Marlin does.
};

/// How the machines of one kind are served.
struct ServedKind {
  std::string_view kind;  ///< `kinematics:`
  /// The first is what its controller speaks where nobody asks for another.
  std::vector<ServedDialect> dialects;
  /// @name Under a real controller; null: such a machine cannot yet be
  /// The machine behind a board's pins, likewise.
  std::unique_ptr<Board> (*board)(const std::filesystem::path& machine,
                                  const TwinOptions& twin) = nullptr;
  /// What its firmware believes, as printer.cfg; `serial`: where the board is.
  std::string (*printer_cfg)(const Machine& machine,
                             const std::string& serial) = nullptr;
  /// As LinuxCNC is told of it, with what its firmware believes.
  linuxcnc::MachineText (*linuxcnc)(const Machine& machine) = nullptr;
};
const ServedKind& ServedKindOf(const std::filesystem::path& machine);
/// By its name; empty: the first. Throws InputError that names those there are.
const ServedDialect& DialectOf(const ServedKind& kind, const std::string& name);

/// The same where it can be served to Klipper's host; else throws InputError that names
/// the kinds which can, at `place`.
const ServedKind& ServedToKlipper(const std::filesystem::path& machine,
                                  const std::string& place);
/// Likewise to LinuxCNC.
const ServedKind& ServedToLinuxCnc(const std::filesystem::path& machine,
                                   const std::string& place);

}  // namespace caltwin
