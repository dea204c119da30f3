#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "sim/link/link.h"

namespace caltwin {

/// Writes bytes to a client; from any thread, and after the client has gone to nobody.
using Say = std::function<void(std::string_view bytes)>;

/// The machine's end of one client's wire.
class Port {
 public:
  Port() = default;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  virtual ~Port() = default;
  /// Whether the board restarts when somebody opens its serial port, as an Arduino
  /// does; what it is sent meanwhile it does not hear.
  virtual bool RestartsWhenOpened() const { return false; }
  /// A client has come. `has_restarted`: by a serial port, of a board that does so.
  virtual void Open(bool /*has_restarted*/) {}
  /// What the client sends, in pieces of any size. false: no client of ours, end it.
  virtual bool Hear(std::string_view bytes) = 0;
};

/// Makes the port of a client that has come.
using OpenPort = std::function<std::unique_ptr<Port>(Say say)>;

/// Ports to a link: a line in, its answer and `ok` out, in RepRapFirmware's manner
/// (session.h). `link` is borrowed. `says_busy`: a line that takes longer is not
/// silent, every two seconds it says `echo:busy: processing`, in Marlin's manner.
OpenPort PortsOf(Link* link, bool says_busy = false);

}  // namespace caltwin
