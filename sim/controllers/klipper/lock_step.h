#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>

#include "sim/controllers/klipper/host_time.h"
#include "sim/controllers/klipper/microcontroller.h"

namespace caltwin {
namespace klipper {

/// A microcontroller and its host in one time, which goes on only while the host waits
/// for it: as fast as both can compute, and alike every time. The host has
/// tools/controllers/host_time.cc in its process.
///
/// Neither side is ever blocked by the other: the line is read also while the host
/// works, and what it does not take at once is kept.
class LockStep {
 public:
  /// `board` is borrowed. `line`, `clock`: descriptors of the line and of the socket
  /// that the host asks for time on, both borrowed too.
  LockStep(Board* board, int line, int clock);

  enum class End {
    kDone,
    kHostEnded,   ///< It is not there any more.
    kHostSilent,  ///< It has worked for longer than `patience` and asked for nothing.
    kStopped,     ///< By `stop`.
  };
  /// Lets time go on until `is_done`, which is asked whenever the host waits for time
  /// and has read all that it was sent. Afterwards time stands still until the next
  /// call; what the host was sent in between it finds first.
  End Run(const std::function<bool()>& is_done,
          std::chrono::milliseconds patience,
          const std::atomic<bool>* stop);

  /// What the host's clock shows, less what it showed at its start [s].
  double host_s() const;
  const Microcontroller& chip() const { return chip_; }

 private:
  /// The host's question; nullopt: `*end` says why none came.
  std::optional<HostWaits> Await(std::chrono::milliseconds patience,
                                 const std::atomic<bool>* stop,
                                 End* end);
  void ReadLine();
  void WriteLine();
  bool Say(const Grant& grant);
  Grant Pass(const HostWaits& waits);
  void AdvanceTo(std::int64_t host_ns);

  Microcontroller chip_;
  int line_, clock_;
  bool is_parked_ = false;
  std::int64_t now_ns_ = kHostStart_ns;
  std::int64_t read_bytes_ = 0, sent_bytes_ = 0;
  Bytes received_{};  ///< Not yet by the chip.
  Bytes unsent_{};
};

}  // namespace klipper
}  // namespace caltwin
