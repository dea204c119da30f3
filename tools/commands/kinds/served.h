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

/// What the controller of that machine speaks: `--dialect`.
std::string_view DialectOf(const std::filesystem::path& machine);

/// The machine of that file, of any kind, as `twin` says it was built. `bench`: the
/// file that `twin` has instruments and artefacts of, for messages. Throws InputError.
Served ServedBy(const std::filesystem::path& machine,
                const TwinOptions& twin,
                const std::string& bench);

}  // namespace caltwin
