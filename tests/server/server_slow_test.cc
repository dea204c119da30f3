#include <atomic>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/server/server_at_work.h"
#include "tools/server/server.h"

namespace caltwin {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

int Connected(int port) {
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_GE(client, 0);
  if (client < 0) return client;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(
      connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return client;
}

bool IsAnswered(int port) {
  const int client = Connected(port);
  constexpr std::string_view kAsk = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
  send(client, kAsk.data(), kAsk.size(), MSG_NOSIGNAL);
  char first = 0;
  const bool is_answered = recv(client, &first, 1, 0) == 1;
  close(client);
  return is_answered;
}

// Forty clients send a byte now and then and never end a request.
TEST(Server, ClientsThatNeverEndAreDropped) {
  Routes routes;
  routes.Add({.method = "GET", .pattern = "/", .handler = [](const HttpRequest&) {
                return HttpResponse{};
              }});
  const Gate gate("127.0.0.1", "");
  const ServerLimits limits{.connections = 40, .to_begin = std::chrono::seconds(1)};
  std::atomic<bool> stop = false;
  std::promise<int> listening;
  std::thread server([&] {
    ServeHttp(routes, gate, {.limits = limits}, &stop, [&](int p) {
      listening.set_value(p);
    });
  });
  const int port = listening.get_future().get();
  std::vector<int> loris;
  for (int i = 0; i < 40; ++i) {
    loris.push_back(Connected(port));
    send(loris.back(), "GET / HT", 8, MSG_NOSIGNAL);
  }

  std::this_thread::sleep_for(std::chrono::milliseconds(1500));

  EXPECT_TRUE(IsAnswered(port));
  for (const int client : loris) {
    char byte = 0;
    EXPECT_LE(recv(client, &byte, 1, 0), 0);
    close(client);
  }
  stop = true;
  server.join();
}

TEST(Server, BytesThatTrickleInDoNotPutTheEndOff) {
  ServerLimits limits;
  limits.to_begin = std::chrono::seconds(1);
  const ServerAtWork served(limits);
  Client client(served.port());
  client.Say("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(client.Hear("hello"), HasSubstr(" 200 "));

  std::atomic<bool> is_dropped = false;
  std::thread trickle([&] {
    while (!is_dropped) {
      client.Say("a");
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });

  EXPECT_THAT(client.Hear("never"), IsEmpty());
  is_dropped = true;
  trickle.join();
}

}  // namespace
}  // namespace caltwin
