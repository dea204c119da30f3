#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "sim/link/link.h"

namespace caltwin {

/// Serves a Link as a machine that terminal programs and G-code senders connect to: a
/// line in, its answer and `ok` out, in RepRapFirmware's manner. A fault of the link is
/// answered by its words, then `ok`, since a sender that gets none waits for ever.
/// Numbered lines (N... *nn) are checked and answered with `Resend: n` where they are
/// damaged or out of turn.
///
/// Both functions block until `*stop` is true, which they notice within a fifth of a
/// second (a signal handler may set it), serving one client at a time: on the port
/// further ones wait until the first has gone. Several may run in threads of their own
/// only on different links, or on one whose Send is safe to call from both.

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
