#include "tools/commands/serve/serve.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <optional>

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/link/line_channel.h"
#include "sim/link/pseudo_terminal.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr milliseconds kGlance{200};  // Between two looks at the stop flag.
/// So long a board takes to restart. Clients throw away what has come by then.
constexpr milliseconds kRestart{300};

constexpr milliseconds kUnread{2000};

/// Tells when somebody opens a terminal.
class Openings {
 public:
  explicit Openings(const fs::path& terminal)
      : watch_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
    if (watch_.number() >= 0)
      inotify_add_watch(watch_.number(), terminal.c_str(), IN_OPEN);
  }
  bool HasBeenOpened() const {
    std::array<char, 4096> events{};
    return read(watch_.number(), events.data(), events.size()) > 0;
  }

 private:
  Descriptor watch_;
};

/// Answers one client until it goes, or until the stop; at a terminal one after
/// another.
void Converse(const OpenPort& open_port,
              int descriptor,
              const std::atomic<bool>& stop,
              const Openings* openings) {
  LineChannel channel(descriptor);
  std::atomic<bool> is_deaf = false;
  const std::unique_ptr<Port> port = open_port([&](std::string_view bytes) {
    // A terminal that nobody reads loses what does not fit; a connection is given up.
    if (openings != nullptr) {
      channel.Write(bytes, kUnread);
    } else if (!is_deaf && !channel.Write(bytes)) {
      is_deaf = true;
    }
  });
  if (openings == nullptr) port->Open(/*has_restarted=*/false);
  const bool restarts = openings != nullptr && port->RestartsWhenOpened();
  std::optional<std::chrono::steady_clock::time_point> restarted;
  while (!stop) {
    const auto [status, bytes] =
        channel.ReadSome(restarted ? kRestart / 4 : kGlance / 4);
    const auto now = std::chrono::steady_clock::now();
    if (restarts && openings->HasBeenOpened()) restarted = now + kRestart;
    if (restarted && now >= *restarted) {
      restarted.reset();
      port->Open(/*has_restarted=*/true);
    }
    if (status == LineChannel::Status::kTimeout) continue;
    if (status == LineChannel::Status::kLine && restarted) continue;
    const bool is_over = status == LineChannel::Status::kClosed || !port->Hear(bytes);
    if (is_over || is_deaf) return;
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

int ServeTcp(const OpenPort& open_port,
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
    Converse(open_port, client, *stop, nullptr);
  }
  return 0;
}

int ServePty(const OpenPort& open_port,
             const fs::path& path,
             const std::atomic<bool>* stop,
             const std::function<void()>& ready) {
  PseudoTerminal terminal(path, "--pty");
  const Openings openings(path);
  if (ready) ready();
  Converse(open_port, terminal.ReleaseMaster(), *stop, &openings);
  return 0;
}

}  // namespace caltwin
