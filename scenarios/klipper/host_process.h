#pragma once

#include <filesystem>
#include <string>

#include <sys/types.h>

#include "sim/base/descriptor.h"

namespace caltwin {

/// The host: `stated`, else $CALTWIN_KLIPPER_HOST, else what tools/setup.sh
/// --controllers has installed beside the program, else kalico of the PATH. Throws
/// InputError where a stated one is not there.
std::filesystem::path HostProgram(const std::string& stated);

/// The host's process, with the library that asks for its time in it
/// (tools/controllers/host_time.cc). Ended with its group.
class HostProcess {
 public:
  HostProcess();
  ~HostProcess();
  HostProcess(const HostProcess&) = delete;
  HostProcess& operator=(const HostProcess&) = delete;

  /// Works in `folder`, where its printer.cfg stands: klippy.log, the API's socket
  /// `api`, and `host.log` with what it prints. Throws InputError where it cannot be
  /// started.
  void Start(const std::filesystem::path& program, const std::filesystem::path& folder);
  /// Our end of the socket that it asks for time on.
  int clock() const { return ours_.number(); }

 private:
  Descriptor ours_{}, theirs_{};
  pid_t pid_ = -1;
};

}  // namespace caltwin
