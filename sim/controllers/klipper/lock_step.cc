#include "sim/controllers/klipper/lock_step.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace caltwin {
namespace klipper {
namespace {

constexpr std::int64_t kLongest_ns = 1'000'000'000;  // One grant.
constexpr std::int64_t kNsPerTick = 1'000'000'000 / kTicksPerSecond;

Clock ChipClock(std::int64_t host_ns) {
  return (host_ns - kChipStart_ns) / kNsPerTick;
}

std::int64_t HostTimeOf(Clock clock) {
  return kChipStart_ns + clock * kNsPerTick;
}

}  // namespace

LockStep::LockStep(Board* board, int line, int clock)
    : chip_(board), line_(line), clock_(clock) {
  fcntl(line_, F_SETFL, fcntl(line_, F_GETFL) | O_NONBLOCK);
  chip_.Advance(ChipClock(kHostStart_ns));
}

double LockStep::host_s() const {
  return static_cast<double>(now_ns_ - kHostStart_ns) * 1e-9;
}

void LockStep::ReadLine() {
  std::array<std::uint8_t, 4096> bytes{};
  for (;;) {
    const ssize_t num = read(line_, bytes.data(), bytes.size());
    if (num <= 0) return;
    received_.insert(received_.end(), bytes.begin(), bytes.begin() + num);
    read_bytes_ += num;
  }
}

void LockStep::WriteLine() {
  if (unsent_.empty()) return;
  const ssize_t num = write(line_, unsent_.data(), unsent_.size());
  if (num <= 0) return;
  unsent_.erase(unsent_.begin(), unsent_.begin() + num);
  sent_bytes_ += num;
}

bool LockStep::Say(const Grant& grant) {
  return send(clock_, &grant, sizeof grant, MSG_NOSIGNAL) == sizeof grant;
}

std::optional<HostWaits> LockStep::Await(std::chrono::milliseconds patience,
                                         const std::atomic<bool>* stop,
                                         End* end) {
  using Now = std::chrono::steady_clock;
  constexpr int kGlance_ms = 50;
  const auto until = Now::now() + patience;
  HostWaits waits;
  while (stop == nullptr || !*stop) {
    std::array<pollfd, 2> requests{pollfd{.fd = clock_, .events = POLLIN, .revents = 0},
                                   pollfd{.fd = line_, .events = POLLIN, .revents = 0}};
    poll(requests.data(), requests.size(), kGlance_ms);
    ReadLine();
    if (requests[0].revents != 0) {
      const ssize_t num = recv(clock_, &waits, sizeof waits, MSG_WAITALL);
      if (num == sizeof waits) return waits;
      *end = End::kHostEnded;
      return std::nullopt;
    }
    if (Now::now() > until) {
      *end = End::kHostSilent;
      return std::nullopt;
    }
  }
  *end = End::kStopped;
  return std::nullopt;
}

void LockStep::AdvanceTo(std::int64_t host_ns) {
  now_ns_ = std::max(now_ns_, host_ns);
  chip_.Advance(std::max(chip_.now(), ChipClock(now_ns_)));
}

// The chip hears what was written until now, now. If it has nothing to say and heard
// nothing, time goes on until it has, or until the host waits no longer.
Grant LockStep::Pass(const HostWaits& waits) {
  AdvanceTo(waits.now_ns);
  // A terminal may keep bytes a moment before the other side sees them.
  constexpr int kPatience_ms = 100, kMostLooks = 50;
  ReadLine();
  for (int i = 0; i < kMostLooks && read_bytes_ < waits.written_bytes; ++i) {
    pollfd line{.fd = line_, .events = POLLIN, .revents = 0};
    poll(&line, 1, kPatience_ms);
    ReadLine();
  }
  const bool is_heard = !received_.empty();
  if (is_heard) chip_.Receive(std::exchange(received_, {}));
  Bytes said = chip_.TakeOutput();
  if (said.empty() && !is_heard && unsent_.empty()) {
    const std::int64_t until_ns = std::min(waits.deadline_ns, now_ns_ + kLongest_ns);
    const Clock deadline = ChipClock(until_ns);
    while (said.empty() && chip_.now() < deadline) {
      const Clock next =
          std::max(chip_.NextEvent().value_or(deadline), chip_.now() + 1);
      chip_.Advance(std::min(next, deadline));
      said = chip_.TakeOutput();
    }
    // A deadline between two ticks is kept as it is.
    const bool is_due = said.empty();
    now_ns_ = std::max(now_ns_, is_due ? until_ns : HostTimeOf(chip_.now()));
  }
  unsent_.insert(unsent_.end(), said.begin(), said.end());
  WriteLine();
  return {.is_parked = 0, .now_ns = now_ns_, .sent_bytes = sent_bytes_};
}

LockStep::End LockStep::Run(const std::function<bool()>& is_done,
                            std::chrono::milliseconds patience,
                            const std::atomic<bool>* stop) {
  if (std::exchange(is_parked_, false) && !Say({})) return End::kHostEnded;
  End end = End::kDone;
  while (const auto waits = Await(patience, stop, &end)) {
    if (is_done()) {
      is_parked_ = true;
      return Say({.is_parked = 1}) ? End::kDone : End::kHostEnded;
    }
    if (!Say(Pass(*waits))) return End::kHostEnded;
  }
  return end;
}

}  // namespace klipper
}  // namespace caltwin
