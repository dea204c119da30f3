#include "sim/controllers/klipper/lock_step.h"

#include <array>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/klipper/host.h"

namespace caltwin {
namespace klipper {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kMs_ns = 1'000'000;

std::array<int, 2> Pair() {
  std::array<int, 2> ends{};
  EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  return ends;
}

/// The host's side, as host_time.cc is one.
class TimedHost {
 public:
  TimedHost(int line, int clock) : line_(line), clock_(clock) {}

  void Write(std::string_view name, const std::vector<Argument>& arguments = {}) {
    const auto all = Commands();
    const auto found = std::ranges::find(all, name, &MessageFormat::name);
    Bytes payload;
    AppendMessage(*found, arguments, &payload);
    const Bytes block = BlockOf(sequence_++, payload);
    written_ += write(line_, block.data(), block.size());
  }
  Grant WaitUntil(std::int64_t deadline_ns) {
    const HostWaits waits{deadline_ns, written_, now_ns_};
    EXPECT_EQ(write(clock_, &waits, sizeof waits), static_cast<ssize_t>(sizeof waits));
    const Grant grant = Take();
    if (grant.is_parked == 0) now_ns_ = grant.now_ns;
    return grant;
  }
  Grant Take() {
    Grant grant;
    EXPECT_EQ(recv(clock_, &grant, sizeof grant, MSG_WAITALL),
              static_cast<ssize_t>(sizeof grant));
    return grant;
  }
  std::int64_t now_ns() const { return now_ns_; }

 private:
  int line_, clock_;
  int sequence_ = 1;
  std::int64_t written_ = 0, now_ns_ = kHostStart_ns;
};

class InLockStep : public testing::Test {
 protected:
  ~InLockStep() override {
    for (const int end : {line_[0], line_[1], clock_[0], clock_[1]}) close(end);
  }
  LockStep::End Run(const std::function<bool()>& is_done) {
    return lock_step_.Run(is_done, milliseconds(5000), nullptr);
  }

  std::array<int, 2> line_ = Pair(), clock_ = Pair();
  ToyBoard board_{};
  LockStep lock_step_{&board_, line_[0], clock_[0]};
  TimedHost host_{line_[1], clock_[1]};
};

TEST_F(InLockStep, TimeGoesOnToWhereTheHostWaitsFor) {
  std::thread host([this] {
    EXPECT_EQ(host_.WaitUntil(kHostStart_ns + 250 * kMs_ns).now_ns,
              kHostStart_ns + 250 * kMs_ns);
    host_.WaitUntil(kHostStart_ns + 300 * kMs_ns);
  });
  EXPECT_EQ(Run([this] { return lock_step_.host_s() >= 0.25; }), LockStep::End::kDone);
  host.join();
  EXPECT_DOUBLE_EQ(lock_step_.host_s(), 0.25);
  // The chip has been on for ten seconds when the host begins.
  EXPECT_EQ(lock_step_.chip().now(), (10'250 * kTicksPerSecond) / 1000);
}

TEST_F(InLockStep, WhatIsWrittenIsAnsweredWithoutTimePassing) {
  std::thread host([this] {
    host_.Write("get_uptime");
    const Grant grant = host_.WaitUntil(kHostStart_ns + kMs_ns);
    EXPECT_EQ(grant.now_ns, kHostStart_ns);
    EXPECT_GT(grant.sent_bytes, 0);
    EXPECT_EQ(host_.WaitUntil(kHostStart_ns + kMs_ns).now_ns, kHostStart_ns + kMs_ns);
    host_.WaitUntil(kHostStart_ns + 2 * kMs_ns);
  });
  EXPECT_EQ(Run([this] { return lock_step_.host_s() > 0; }), LockStep::End::kDone);
  host.join();
}

TEST_F(InLockStep, ParkedNothingGoesOnUntilTheNextRun) {
  std::thread host([this] {
    EXPECT_EQ(host_.WaitUntil(kHostStart_ns + kMs_ns).is_parked, 1);
    host_.Take();  // Go on, and look again.
    EXPECT_EQ(host_.WaitUntil(kHostStart_ns + kMs_ns).now_ns, kHostStart_ns + kMs_ns);
    host_.WaitUntil(kHostStart_ns + 2 * kMs_ns);
  });
  EXPECT_EQ(Run([] { return true; }), LockStep::End::kDone);
  EXPECT_DOUBLE_EQ(lock_step_.host_s(), 0);
  EXPECT_EQ(Run([this] { return lock_step_.host_s() > 0; }), LockStep::End::kDone);
  host.join();
}

TEST_F(InLockStep, AHostThatWaitsForNothingGetsNoMoreThanASecondAtATime) {
  std::thread host([this] {
    EXPECT_EQ(host_.WaitUntil(INT64_MAX).now_ns, kHostStart_ns + 1000 * kMs_ns);
    host_.WaitUntil(INT64_MAX);
  });
  EXPECT_EQ(Run([this] { return lock_step_.host_s() > 0; }), LockStep::End::kDone);
  host.join();
}

TEST_F(InLockStep, AHostThatIsGoneOrSilentIsSaidSo) {
  EXPECT_EQ(lock_step_.Run([] { return false; }, milliseconds(60), nullptr),
            LockStep::End::kHostSilent);
  const std::atomic<bool> stop = true;
  EXPECT_EQ(lock_step_.Run([] { return false; }, milliseconds(5000), &stop),
            LockStep::End::kStopped);
  shutdown(clock_[1], SHUT_RDWR);
  EXPECT_EQ(Run([] { return false; }), LockStep::End::kHostEnded);
}

}  // namespace
}  // namespace klipper
}  // namespace caltwin
