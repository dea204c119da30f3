#pragma once

#include <filesystem>
#include <string>

#include <sys/types.h>

#include "sim/base/descriptor.h"

namespace caltwin {

/// LinuxCNC's processes, in namespaces of their own: shared memory, ports, process
/// numbers and /tmp are nobody else's, so several may run, none meets one that is
/// installed for use, and all of them are gone when this object is, or when caltwin is,
/// however it ends. Needs user namespaces, no privileges.
class LinuxCncSandbox {
 public:
  LinuxCncSandbox();
  ~LinuxCncSandbox();
  LinuxCncSandbox(const LinuxCncSandbox&) = delete;
  LinuxCncSandbox& operator=(const LinuxCncSandbox&) = delete;

  /// Compiles the component for it and starts it. `folder` becomes its /tmp and holds
  /// `page`, and in `config` the file `ini` and what it names. What it prints is in
  /// `linuxcnc.log` there. Throws InputError where it is not installed or cannot be
  /// started.
  void Start(const std::filesystem::path& folder, const std::string& ini);
  /// Our end of the line to whoever sits at it (component/caltwin_operator.py).
  int line() const { return ours_.number(); }
  bool HasEnded();

 private:
  Descriptor ours_{}, theirs_{};    ///< Of the operator's line.
  Descriptor alive_{}, watched_{};  ///< A pipe that is open as long as we live.
  pid_t pid_ = -1;
};

}  // namespace caltwin
