#pragma once

#include <filesystem>
#include <string>

#include "sim/base/descriptor.h"

namespace caltwin {

/// A pseudo-terminal, raw on both sides, and a symbolic link to where clients open it,
/// which is removed at the end. A client may come and go: the terminal stays.
class PseudoTerminal {
 public:
  /// `option`: how messages name it, "--pty". Throws InputError where `path` is taken
  /// by anything but a dangling link, or cannot be made.
  PseudoTerminal(const std::filesystem::path& path, const std::string& option);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// The link.
  const std::filesystem::path& path() const { return path_; }
  /// Our side.
  int number() const { return master_.number(); }
  int ReleaseMaster() { return master_.Release(); }

 private:
  Descriptor master_;
  Descriptor client_side_;
  std::filesystem::path path_;
};

}  // namespace caltwin
