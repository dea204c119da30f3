#include "sim/link/line_channel.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace caltwin {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Waits until the descriptor is ready or the time is up; false: the time is up.
bool WaitFor(int descriptor, short events, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
    const auto wait = std::clamp<std::int64_t>(left.count(), 0, 3'600'000);
    pollfd request{.fd = descriptor, .events = events, .revents = 0};
    const int ready = poll(&request, 1, static_cast<int>(wait));
    if (ready > 0) return true;
    if (ready == 0) return false;
    if (errno != EINTR) return true;  // The read or write that follows says why.
  }
}

}  // namespace

LineChannel::LineChannel(int descriptor, std::size_t most_bytes)
    : descriptor_(descriptor), most_bytes_(most_bytes) {
  fcntl(descriptor_, F_SETFL, fcntl(descriptor_, F_GETFL) | O_NONBLOCK);
}

LineChannel::~LineChannel() {
  close(descriptor_);
}

bool LineSplitter::Take(std::string* line) {
  for (;;) {
    const std::size_t end = waiting_.find_first_of("\r\n");
    if (end == std::string::npos) return false;
    *line = waiting_.substr(0, end);
    waiting_.erase(0, end + 1);
    if (!line->empty()) return true;
  }
}

std::optional<std::string> LineChannel::ReadNow() {
  std::array<char, 4096> buffer{};
  const ssize_t count = read(descriptor_, buffer.data(), buffer.size());
  if (count > 0) return std::string(buffer.data(), static_cast<std::size_t>(count));
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return "";
  return std::nullopt;
}

bool LineChannel::Fill() {
  const auto bytes = ReadNow();
  if (bytes) waiting_.Add(*bytes);
  return bytes.has_value();
}

LineChannel::Result LineChannel::ReadSome(milliseconds patience) {
  if (!WaitFor(descriptor_, POLLIN, Clock::now() + patience)) {
    return {.status = Status::kTimeout};
  }
  auto bytes = ReadNow();
  if (!bytes) return {.status = Status::kClosed};
  return {.status = Status::kLine, .line = std::move(*bytes)};
}

LineChannel::Result LineChannel::ReadLine(milliseconds patience) {
  const Clock::time_point until = Clock::now() + patience;
  std::string line;
  while (!waiting_.Take(&line)) {
    if (waiting_.size() > most_bytes_) return {.status = Status::kClosed};
    if (!WaitFor(descriptor_, POLLIN, until)) return {.status = Status::kTimeout};
    if (!Fill()) return {.status = Status::kClosed};
  }
  return {.status = Status::kLine, .line = std::move(line)};
}

bool LineChannel::Write(std::string_view text, milliseconds patience) {
  const std::lock_guard<std::mutex> lock(writing_);
  const Clock::time_point until = Clock::now() + patience;
  std::size_t sent = 0;
  while (sent < text.size()) {
    ssize_t count =
        send(descriptor_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == ENOTSOCK) {
      count = write(descriptor_, text.data() + sent, text.size() - sent);
    }
    if (count > 0) {
      sent += static_cast<std::size_t>(count);
      continue;
    }
    const bool is_broken = count < 0 && errno != EAGAIN && errno != EINTR;
    if (is_broken || !WaitFor(descriptor_, POLLOUT, until)) return false;
  }
  return true;
}

void LineChannel::Discard() {
  waiting_.Clear();
  const Clock::time_point now = Clock::now();
  while (WaitFor(descriptor_, POLLIN, now) && Fill() && waiting_.size() > 0) {
    waiting_.Clear();
  }
}

}  // namespace caltwin
