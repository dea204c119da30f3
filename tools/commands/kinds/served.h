#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "sim/link/link.h"
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
};
const ServedKind& ServedKindOf(const std::filesystem::path& machine);

}  // namespace caltwin
