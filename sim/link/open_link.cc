#include "sim/link/open_link.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "sim/base/descriptor.h"
#include "sim/base/input_error.h"
#include "sim/link/reply.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr int kDefaultBaud = 115200;
constexpr std::array<std::pair<int, speed_t>, 8> kSpeeds = {{{9600, B9600},
                                                             {19200, B19200},
                                                             {38400, B38400},
                                                             {57600, B57600},
                                                             {115200, B115200},
                                                             {230400, B230400},
                                                             {500000, B500000},
                                                             {1000000, B1000000}}};

std::optional<int> WholeNumber(std::string_view text) {
  int value = 0;
  const auto [stop, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Connects to one of the host's addresses; -1 and errno where none answers.
int Connect(const addrinfo* addresses) {
  int error = ECONNREFUSED;
  for (const addrinfo* a = addresses; a != nullptr; a = a->ai_next) {
    const int descriptor =
        socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
    if (descriptor < 0) continue;
    if (connect(descriptor, a->ai_addr, a->ai_addrlen) == 0) {
      const int on = 1;
      setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return descriptor;
    }
    error = errno;
    close(descriptor);
  }
  errno = error;
  return -1;
}

int OpenTcp(const std::string& host, int port) {
  const std::string where = fmt::format("tcp:{}:{}", host, port);
  if (port < 1 || port > 65535) {
    throw InputError({}, where + ": a port is a number from 1 to 65535");
  }
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* addresses = nullptr;
  const int problem =
      getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &addresses);
  if (problem != 0) {
    throw InputError({}, fmt::format("{}: {}", where, gai_strerror(problem)));
  }
  const int descriptor = Connect(addresses);
  const int error = errno;
  freeaddrinfo(addresses);
  if (descriptor < 0) {
    throw InputError({},
                     fmt::format("{}: {}", where, SystemSays(error)),
                     "is the machine on, and is this its G-code port?");
  }
  return descriptor;
}

int OpenSerial(const std::string& device, int baud) {
  const auto* const speed =
      std::ranges::find(kSpeeds, baud, [](const auto& known) { return known.first; });
  if (speed == kSpeeds.end()) {
    throw InputError(
        {},
        fmt::format("serial:{}: baud = {} is not a speed known here", device, baud),
        "9600 19200 38400 57600 115200 230400 500000 1000000");
  }
  const int descriptor =
      open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    throw InputError({}, fmt::format("serial:{}: {}", device, SystemSays(errno)));
  }
  termios mode{};
  if (tcgetattr(descriptor, &mode) != 0) {
    close(descriptor);
    throw InputError({}, fmt::format("serial:{}: this is not a serial port", device));
  }
  cfmakeraw(&mode);
  mode.c_cflag |= CLOCAL | CREAD;
  cfsetispeed(&mode, speed->second);
  cfsetospeed(&mode, speed->second);
  if (tcsetattr(descriptor, TCSANOW, &mode) != 0) {
    const int error = errno;
    close(descriptor);
    throw InputError({}, fmt::format("serial:{}: {}", device, SystemSays(error)));
  }
  return descriptor;
}

std::unique_ptr<Link> OpenTcpUrl(const std::string& url, std::string_view rest) {
  const std::size_t colon = rest.rfind(':');
  const auto port = colon == std::string_view::npos
                        ? std::nullopt
                        : WholeNumber(rest.substr(colon + 1));
  if (!port || colon == 0) {
    throw InputError({}, fmt::format("'{}' is not of the form tcp:host:port", url));
  }
  std::string_view host = rest.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  }
  return std::make_unique<TcpLink>(std::string(host), *port);
}

std::unique_ptr<Link> OpenSerialUrl(const std::string& url, std::string_view rest) {
  const std::size_t question = rest.find('?');
  const std::string device(rest.substr(0, question));
  if (question == std::string_view::npos) {
    return std::make_unique<SerialLink>(device, kDefaultBaud);
  }
  const std::string_view option = rest.substr(question + 1);
  const auto baud =
      option.starts_with("baud=") ? WholeNumber(option.substr(5)) : std::nullopt;
  if (!baud) {
    throw InputError(
        {},
        fmt::format("'{}': the only option of a serial link is baud=", url),
        "serial:/dev/ttyACM0?baud=115200");
  }
  return std::make_unique<SerialLink>(device, *baud);
}

}  // namespace

Expected<std::vector<std::string>> ChannelLink::Send(
    std::string_view line, std::chrono::milliseconds patience) {
  using Kind = MachineFault::Kind;
  const auto until = std::chrono::steady_clock::now() + patience;
  const auto fault = [&](Kind kind, std::string_view what) {
    return tl::make_unexpected(
        MachineFault{.kind = kind, .reply = fmt::format("{} ('{}')", what, line)});
  };
  channel_.Discard();
  if (!channel_.WriteLine(line)) return fault(Kind::kLinkLost, "the link is closed");
  std::vector<std::string> lines;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(
        until - std::chrono::steady_clock::now());
    auto [status, text] =
        channel_.ReadLine(std::max(left, std::chrono::milliseconds{0}));
    if (status == LineChannel::Status::kTimeout) {
      return fault(Kind::kTimeout, "no ok in time");
    }
    if (status == LineChannel::Status::kClosed) {
      return fault(Kind::kLinkLost, "the link closed before the ok");
    }
    if (text == "ok") return JudgeReply(std::move(lines));
    if (text.starts_with("ok ")) {
      lines.push_back(text.substr(3));
      return JudgeReply(std::move(lines));
    }
    if (!text.starts_with("echo:busy")) lines.push_back(std::move(text));
  }
}

TcpLink::TcpLink(const std::string& host, int port)
    : ChannelLink(OpenTcp(host, port)) {}

SerialLink::SerialLink(const std::string& device, int baud)
    : ChannelLink(OpenSerial(device, baud)) {}

std::unique_ptr<Link> OpenLink(const std::string& url) {
  const std::size_t colon = url.find(':');
  const std::string kind = url.substr(0, colon);
  const std::string_view rest =
      colon == std::string::npos ? "" : std::string_view(url).substr(colon + 1);
  if (kind == "tcp") return OpenTcpUrl(url, rest);
  if (kind == "serial") return OpenSerialUrl(url, rest);
  if (kind == "transcript") return std::make_unique<TranscriptLink>(std::string(rest));
  throw InputError({},
                   fmt::format("'{}' is no link", url),
                   "twin:M.yaml, serial:/dev/tty...?baud=, tcp:host:port or "
                   "transcript:FILE");
}

}  // namespace caltwin
