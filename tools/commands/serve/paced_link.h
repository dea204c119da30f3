#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "scenarios/interrupt.h"
#include "sim/link/link.h"

namespace caltwin {

/// A link that answers when the machine would: a line that took it some seconds of its
/// own time takes as many here, divided by the speed. A move that waits in a queue
/// takes its time with the line that has it performed.
class PacedLink final : public Link {
 public:
  /// `inner` is borrowed. `time_s`: the machine's own time. `speed` infinite: at once.
  PacedLink(Link* inner, std::function<double()> time_s, double speed)
      : inner_(inner), time_s_(std::move(time_s)), speed_(speed) {}

  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    if (!time_s_) return inner_->Send(line, patience);
    const auto begin = std::chrono::steady_clock::now();
    const double before_s = time_s_();
    auto reply = inner_->Send(line, patience);
    constexpr double kLongest_s = 1e7;  // Nobody waits that long.
    constexpr std::chrono::milliseconds kGlance(50);
    const std::chrono::duration<double> takes(
        std::min((time_s_() - before_s) / speed_, kLongest_s));
    const auto end =
        begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(takes);
    while (!InterruptRequested() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_until(
          std::min(end, std::chrono::steady_clock::now() + kGlance));
    }
    return reply;
  }

 private:
  Link* inner_;
  std::function<double()> time_s_;
  double speed_;
};

}  // namespace caltwin
