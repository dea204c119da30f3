#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/link/line_channel.h"
#include "sim/link/open_link.h"

namespace caltwin {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;

/// A machine on a real loopback socket: one client, its conversation a function.
class OneClientServer {
 public:
  explicit OneClientServer(std::function<void(LineChannel*)> converse) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const plain = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(listener_, plain, size), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    getsockname(listener_, plain, &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this, converse = std::move(converse)] {
      LineChannel channel(accept(listener_, nullptr, nullptr));
      converse(&channel);
    });
  }
  ~OneClientServer() {
    thread_.join();
    close(listener_);
  }
  int port() const { return port_; }

 private:
  int listener_ = -1;
  int port_ = 0;
  std::thread thread_;
};

TEST(TcpLink, SendsALineAndCollectsTheAnswer) {
  OneClientServer server([](LineChannel* channel) {
    const auto [status, line] = channel->ReadLine(seconds(5));
    channel->WriteLine("echo:busy: processing");
    channel->WriteLine("got " + line + "\r");
    channel->WriteLine("\nok");
  });
  TcpLink link("localhost", server.port());

  const auto reply = link.Send("M114", seconds(5));

  ASSERT_TRUE(reply.has_value());
  EXPECT_THAT(*reply, ElementsAre("got M114"));
}

TEST(TcpLink, AnswerBehindTheOkCounts) {
  OneClientServer server([](LineChannel* channel) {
    channel->ReadLine(seconds(5));
    channel->WriteLine("ok T:0.0 /0.0");
  });
  TcpLink link("127.0.0.1", server.port());

  EXPECT_THAT(*link.Send("M105", seconds(5)), ElementsAre("T:0.0 /0.0"));
}

TEST(TcpLink, RefusalIsAFault) {
  OneClientServer server([](LineChannel* channel) {
    channel->ReadLine(seconds(5));
    channel->WriteLine("Error: G0/G1: insufficient axes homed");
    channel->WriteLine("ok");
  });
  TcpLink link("127.0.0.1", server.port());

  const auto reply = link.Send("G0 X1", seconds(5));

  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kRefused);
}

TEST(TcpLink, SilenceIsATimeoutAndTheLateAnswerIsDropped) {
  OneClientServer server([](LineChannel* channel) {
    channel->ReadLine(seconds(5));
    std::this_thread::sleep_for(milliseconds(100));
    channel->WriteLine("late");
    channel->WriteLine("ok");
    channel->ReadLine(seconds(5));
    channel->WriteLine("ok");
  });
  TcpLink link("127.0.0.1", server.port());

  const auto reply = link.Send("G28", milliseconds(20));

  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kTimeout);
  std::this_thread::sleep_for(milliseconds(300));
  const auto second = link.Send("M114", seconds(5));
  ASSERT_TRUE(second.has_value());
  EXPECT_THAT(*second, testing::IsEmpty());
}

TEST(TcpLink, ServerGoneIsALinkLost) {
  OneClientServer server([](LineChannel* channel) { channel->ReadLine(seconds(5)); });
  TcpLink link("127.0.0.1", server.port());

  const auto reply = link.Send("G28", seconds(5));

  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kLinkLost);
}

TEST(LineChannel, EndlessLineClosesIt) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  LineChannel channel(ends[0], 1000);
  LineChannel other(ends[1]);

  EXPECT_TRUE(other.WriteLine(std::string(900, 'x')));
  EXPECT_EQ(channel.ReadLine(seconds(1)).line.size(), 900);
  const std::string noise(5000, 'x');
  ASSERT_EQ(write(ends[1], noise.data(), noise.size()), 5000);
  EXPECT_EQ(channel.ReadLine(seconds(1)).status, LineChannel::Status::kClosed);
}

}  // namespace
}  // namespace caltwin
