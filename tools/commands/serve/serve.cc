#include "tools/commands/serve/serve.h"

#include <cerrno>
#include <chrono>

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/link/line_channel.h"
#include "sim/link/pseudo_terminal.h"
#include "tools/commands/serve/session.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr milliseconds kGlance{200};  // Between two looks at the stop flag.
constexpr std::size_t kLongestLine = 4096;

/// Answers one client until it goes, or until the stop.
void Converse(Link* link, int descriptor, const std::atomic<bool>& stop) {
  LineChannel channel(descriptor, kLongestLine);
  ServeSession session(link);
  while (!stop) {
    const auto [status, line] = channel.ReadLine(kGlance);
    if (status == LineChannel::Status::kClosed) return;
    if (status == LineChannel::Status::kTimeout) continue;
    for (const std::string& answer : session.Answer(line)) {
      if (!channel.WriteLine(answer)) return;
    }
  }
}

int ListenOn(int port) {
  const auto fail = [&]() -> int {
    throw InputError({},
                     fmt::format("--tcp {}: {}", port, SystemSays(errno)),
                     "--tcp 0 takes any free port");
  };
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return fail();
  const int on = 1;
  setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) !=
          0 ||
      listen(descriptor, 4) != 0) {
    const int error = errno;
    close(descriptor);
    errno = error;
    return fail();
  }
  return descriptor;
}

int PortOf(int descriptor) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

bool IsReadable(int descriptor, milliseconds patience) {
  pollfd request{.fd = descriptor, .events = POLLIN, .revents = 0};
  return poll(&request, 1, static_cast<int>(patience.count())) > 0;
}

}  // namespace

int ServeTcp(Link* link,
             int port,
             const std::atomic<bool>* stop,
             const std::function<void(int port)>& listening) {
  if (port < 0 || port > 65535) {
    throw InputError({},
                     fmt::format("--tcp {}: a port is a number from 1 to 65535", port));
  }
  const Descriptor listener(ListenOn(port));
  if (listening) listening(PortOf(listener.number()));
  while (!*stop) {
    if (!IsReadable(listener.number(), kGlance)) continue;
    const int client = accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    const int on = 1;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    Converse(link, client, *stop);
  }
  return 0;
}

int ServePty(Link* link,
             const fs::path& path,
             const std::atomic<bool>* stop,
             const std::function<void()>& ready) {
  PseudoTerminal terminal(path, "--pty");
  if (ready) ready();
  Converse(link, terminal.ReleaseMaster(), *stop);
  return 0;
}

}  // namespace caltwin
