#include "tools/commands/serve/serve_klipper.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/controllers/klipper/microcontroller.h"
#include "sim/link/pseudo_terminal.h"

namespace caltwin {
namespace {

using klipper::Clock;
using std::chrono::nanoseconds;
using Now = std::chrono::steady_clock;

constexpr std::int64_t kNsPerTick = 1'000'000'000 / klipper::kTicksPerSecond;
constexpr nanoseconds kGlance = std::chrono::milliseconds(10);
/// So late the process is woken on an idle computer. What is beyond, the computer was
/// busy, and likely kept the host waiting too.
constexpr nanoseconds kUsuallyLate = std::chrono::milliseconds(2);
/// A host takes a chip that has just been switched on for one that was reset.
constexpr Clock kOnBefore = 10 * klipper::kTicksPerSecond;
/// Said while nobody listens; the host finds its way into what is left.
constexpr std::size_t kMostUnheard = 16'384;

/// The chip on its line, the line's descriptor non-blocking.
class Line {
 public:
  Line(Board* board, int descriptor) : chip_(board), descriptor_(descriptor) {
    fcntl(descriptor_, F_SETFL, fcntl(descriptor_, F_GETFL) | O_NONBLOCK);
    chip_.Advance(kOnBefore);
  }

  /// Waits for bytes or for the next event, and lets the chip see them.
  void Turn() {
    const Clock due = chip_.NextEvent().value_or(chip_.now() + kOnBefore);
    Wait(
        std::clamp(nanoseconds((due - Ticks()) * kNsPerTick), nanoseconds(0), kGlance));
    klipper::Bytes bytes(4096);
    const ssize_t num = read(descriptor_, bytes.data(), bytes.size());
    const Clock now = std::max(Ticks(), chip_.now());
    if (num > 0) {
      bytes.resize(static_cast<std::size_t>(num));
      // Woken late, on a busy computer: they may well have come before what was due.
      chip_.Advance(std::clamp(now, chip_.now(), std::max(chip_.now(), due - 1)));
      chip_.Receive(bytes);
    }
    chip_.Advance(now);
    Write();
  }

  const klipper::Microcontroller& chip() const { return chip_; }

 private:
  Clock Ticks() const {
    const nanoseconds since = Now::now() - start_;
    return kOnBefore + since.count() / kNsPerTick;
  }
  /// The chip's clock does not go on while the process was kept waiting for longer than
  /// it asked to.
  void StandStillBeyond(nanoseconds allowed) {
    const nanoseconds gone((Ticks() - chip_.now()) * kNsPerTick);
    if (gone > allowed) start_ += gone - allowed;
  }
  void Wait(nanoseconds patience) const {
    const bool has_more = !unsent_.empty();
    pollfd request{.fd = descriptor_,
                   .events = static_cast<short>(has_more ? POLLIN | POLLOUT : POLLIN),
                   .revents = 0};
    const timespec limit{.tv_sec = patience.count() / 1'000'000'000,
                         .tv_nsec = patience.count() % 1'000'000'000};
    ppoll(&request, 1, &limit, nullptr);
  }
  void Write() {
    const klipper::Bytes said = chip_.TakeOutput();
    unsent_.insert(unsent_.end(), said.begin(), said.end());
    if (unsent_.empty()) return;
    const ssize_t num = write(descriptor_, unsent_.data(), unsent_.size());
    if (num > 0) unsent_.erase(unsent_.begin(), unsent_.begin() + num);
    if (unsent_.size() > kMostUnheard) unsent_.clear();
  }

  klipper::Microcontroller chip_;
  int descriptor_;
  Now::time_point start_ = Now::now();
  klipper::Bytes unsent_{};
};

}  // namespace

int ServeKlipper(Board* board,
                 const std::filesystem::path& path,
                 const std::atomic<bool>* stop,
                 const std::function<void()>& ready,
                 const std::function<void(std::string_view why)>& note) {
  const PseudoTerminal terminal(path, "--klipper");
  Line line(board, terminal.number());
  if (ready) ready();
  std::optional<std::string_view> told;
  while (!*stop) {
    line.Turn();
    const auto why = line.chip().shutdown();
    if (why && why != told && note) note(*why);
    told = why;
  }
  return 0;
}

}  // namespace caltwin
