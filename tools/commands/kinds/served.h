#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "sim/controllers/board.h"
#include "sim/controllers/linuxcnc/config.h"
#include "sim/link/link.h"
#include "sim/machine/machine.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A simulated machine with its controller, on a wire.
struct Served {
  std::string about{};  ///< Its name, its fidelity and what its controller speaks.
  std::shared_ptr<void> machine{};
  Link* link = nullptr;
};

/// How the machines of one kind are served.
struct ServedKind {
  std::string_view kind;     ///< `kinematics:`
  std::string_view dialect;  ///< What its controller speaks: `--dialect`.
  /// The machine of that file, as `twin` says it was built. `bench`: the file that
  /// `twin` has instruments and artefacts of, for messages. Throws InputError.
  Served (*make)(const std::filesystem::path& machine,
                 const TwinOptions& twin,
                 const std::string& bench);
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

/// The same where it can be served to Klipper's host; else throws InputError that names
/// the kinds which can, at `place`.
const ServedKind& ServedToKlipper(const std::filesystem::path& machine,
                                  const std::string& place);
/// Likewise to LinuxCNC.
const ServedKind& ServedToLinuxCnc(const std::filesystem::path& machine,
                                   const std::string& place);

}  // namespace caltwin
