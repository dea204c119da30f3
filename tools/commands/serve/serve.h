#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "sim/link/link.h"
#include "tools/commands/serve/port.h"

namespace caltwin {

/// One link for several threads: a line is sent only when the one before is answered.
class SharedLink : public Link {
 public:
  /// `inner` is borrowed.
  explicit SharedLink(Link* inner) : inner_(inner) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return inner_->Send(line, patience);
  }

 private:
  Link* inner_;
  std::mutex mutex_{};
};

/// Serves a machine that terminal programs and G-code senders connect to, a port
/// (port.h) for each.
///
/// The functions block until `*stop` is true, which they notice within a fifth of a
/// second (a signal handler may set it), serving one client at a time: on the port
/// further ones wait until the first has gone. To serve one machine on a port and a
/// terminal at once, run each in a thread of its own, a Link as a SharedLink.

/// Listens on 127.0.0.1 only. `port` 0: any free one. `listening` is called once with
/// the port. Returns 0; throws InputError where the port cannot be had.
int ServeTcp(const OpenPort& open_port,
             int port,
             const std::atomic<bool>* stop,
             const std::function<void(int port)>& listening = {});

/// Makes a pseudo-terminal and `path` a symbolic link to it, removed at the end; a
/// client may open and close it any number of times, and the port is told when one has.
/// `ready` is called once. Returns 0; throws InputError where `path` is taken by
/// anything but a dangling link, or cannot be made.
int ServePty(const OpenPort& open_port,
             const std::filesystem::path& path,
             const std::atomic<bool>* stop,
             const std::function<void()>& ready = {});

}  // namespace caltwin
