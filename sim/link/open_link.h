#pragma once

#include <memory>
#include <string>

#include "sim/link/line_channel.h"
#include "sim/link/link.h"

namespace caltwin {

/// A machine at the other end of a line channel: a line sent, lines received until `ok`
/// (what stands behind the ok on its line is an answer too; `echo:busy` lines are
/// skipped). After a time-out the machine's late answer may still come; it is dropped
/// before the next line is sent.
class ChannelLink : public Link {
 public:
  explicit ChannelLink(int descriptor) : channel_(descriptor) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  bool Interject(std::string_view line) override { return channel_.WriteLine(line); }

 private:
  LineChannel channel_;
};

/// A machine on a TCP port, IPv4 or IPv6. Throws InputError where nobody answers.
class TcpLink : public ChannelLink {
 public:
  TcpLink(const std::string& host, int port);
};

/// A machine on a serial port: raw, 8 data bits, no parity, 1 stop bit. Throws
/// InputError for a device that cannot be opened or a speed it does not know.
class SerialLink : public ChannelLink {
 public:
  SerialLink(const std::string& device, int baud);
};

/// Opens `serial:/dev/ttyACM0?baud=115200` (the default speed), `tcp:host:port`
/// (`tcp:[::1]:8023`) or `transcript:FILE`. Throws InputError for any other URL and
/// where the machine cannot be reached.
std::unique_ptr<Link> OpenLink(const std::string& url);

}  // namespace caltwin
