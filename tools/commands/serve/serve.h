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

/// Serves a Link as a machine that terminal programs and G-code senders connect to: a
/// line in, its answer and `ok` out, in RepRapFirmware's manner. A fault of the link is
/// answered by its words, then `ok`, since a sender that gets none waits for ever.
/// Numbered lines (N... *nn) are checked and answered with `Resend: n` where they are
/// damaged or out of turn.
///
/// Both functions block until `*stop` is true, which they notice within a fifth of a
/// second (a signal handler may set it), serving one client at a time: on the port
/// further ones wait until the first has gone. To serve one machine on a port and a
/// terminal at once, run each in a thread of its own on the same SharedLink.

/// Listens on 127.0.0.1 only. `port` 0: any free one. `listening` is called once with
/// the port. Returns 0; throws InputError where the port cannot be had.
int ServeTcp(Link* link,
             int port,
             const std::atomic<bool>* stop,
             const std::function<void(int port)>& listening = {});

/// Makes a pseudo-terminal and `path` a symbolic link to it, removed at the end; a
/// client may open and close it any number of times. `ready` is called once. Returns 0;
/// throws InputError where `path` is taken by anything but a dangling link, or cannot
/// be made.
int ServePty(Link* link,
             const std::filesystem::path& path,
             const std::atomic<bool>* stop,
             const std::function<void()>& ready = {});

}  // namespace caltwin
