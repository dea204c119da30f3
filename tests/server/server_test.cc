#include "tools/server/server.h"

#include <array>
#include <atomic>
#include <future>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "tools/server/events.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// A connection that says what it is told, byte for byte.
class Client {
 public:
  explicit Client(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_GE(socket_, 0);
    if (socket_ < 0) return;
    EXPECT_EQ(
        connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address),
        0);
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void Say(const std::string& text) {
    send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  /// What comes until `end` stands in it, or the server closes.
  std::string Hear(const std::string& end) {
    std::array<char, 4096> buffer{};
    while (heard_.find(end) == std::string::npos) {
      const ssize_t count = recv(socket_, buffer.data(), buffer.size(), 0);
      if (count <= 0) break;
      heard_.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return std::exchange(heard_, "");
  }

 private:
  int socket_;
  std::string heard_{};
};

/// A server on a port of its own, for as long as it lives.
class Served {
 public:
  explicit Served(ServerLimits limits = {}) {
    const auto add =
        [&](const char* method, const char* path, Route::Pace pace, Handler go) {
          routes_.Add({.method = method,
                       .pattern = path,
                       .handler = std::move(go),
                       .pace = pace,
                       .most_bytes = 100});
        };
    add("GET", "/hello", Route::Pace::kQuick, [](const HttpRequest&) {
      return HttpResponse{.content_type = "text/plain", .body = "hello"};
    });
    add("POST", "/echo", Route::Pace::kSlow, [](const HttpRequest& request) {
      return HttpResponse{.content_type = "text/plain",
                          .body = "<" + request.body + ">"};
    });
    add("GET", "/events", Route::Pace::kQuick, [this](const HttpRequest&) {
      return HttpResponse{.events = topic_};
    });
    std::promise<int> port;
    server_ = std::thread([this, limits, &port] {
      ServeHttp(routes_, gate_, {.limits = limits}, &stop_, [&](int p) {
        port.set_value(p);
      });
    });
    port_ = port.get_future().get();
  }
  ~Served() {
    stop_ = true;
    server_.join();
  }
  int port() const { return port_; }
  EventTopic& topic() { return *topic_; }

 private:
  Routes routes_{};
  Gate gate_{"127.0.0.1", ""};
  std::shared_ptr<EventTopic> topic_ = std::make_shared<EventTopic>();
  std::atomic<bool> stop_ = false;
  std::thread server_{};
  int port_ = 0;
};

TEST(Server, OneConnectionIsAnsweredAgainAndAgain) {
  const Served served;
  Client client(served.port());

  client.Say("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(client.Hear("hello"), StartsWith("HTTP/1.1 200 OK\r\n"));
  client.Say("POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc");
  EXPECT_THAT(client.Hear("<abc>"), HasSubstr("<abc>"));
  client.Say("HEAD /hello HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const std::string head = client.Hear("never");
  EXPECT_THAT(head, HasSubstr("Content-Length: 5"));
  EXPECT_THAT(head, testing::EndsWith("\r\n\r\n"));
}

TEST(Server, WhatIsNoRequestIsRefusedAndClosed) {
  const Served served;
  for (const auto& [said, status] :
       {std::pair{"nonsense\r\n\r\n", " 400 "},
        std::pair{"GET /hello HTTP/1.1\r\n\r\n", " 421 "},
        std::pair{"GET /%zz HTTP/1.1\r\nHost: localhost\r\n\r\n", " 400 "},
        std::pair{"DELETE /hello HTTP/1.1\r\nHost: localhost\r\n\r\n", " 405 "},
        std::pair{"GET /else HTTP/1.1\r\nHost: localhost\r\n\r\n", " 404 "},
        std::pair{
            "POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 101\r\n\r\n",
            " 413 "}}) {
    Client client(served.port());
    client.Say(said);
    const std::string answer = client.Hear("never");
    EXPECT_THAT(answer.substr(0, answer.find('\r')), HasSubstr(status)) << said;
    EXPECT_THAT(answer, HasSubstr("application/problem+json")) << said;
  }
}

TEST(Server, LongHeadersAreRefused) {
  const Served served;
  Client client(served.port());

  client.Say("GET /hello HTTP/1.1\r\nHost: localhost\r\nX: " +
             std::string(20'000, 'a') + "\r\n\r\n");

  EXPECT_THAT(client.Hear("never"), StartsWith("HTTP/1.1 431 "));
}

TEST(Server, EventsReachWhoListens) {
  Served served;
  Client client(served.port());
  client.Say("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(client.Hear("retry"), HasSubstr("text/event-stream"));
  while (served.topic().listeners() == 0) std::this_thread::yield();

  served.topic().Publish("touch", "{\"z\":1}");

  EXPECT_THAT(client.Hear("}\n\n"), HasSubstr("event: touch\ndata: {\"z\":1}"));
}

bool IsRefused(int port) {
  const Routes routes;
  const Gate gate("127.0.0.1", "");
  const std::atomic<bool> stop = true;
  try {
    ServeHttp(routes, gate, {.port = port}, &stop, [](int) {});
  } catch (const InputError&) {
    return true;
  }
  return false;
}

TEST(Server, APortThatIsTakenIsSaid) {
  const Served served;

  EXPECT_TRUE(IsRefused(served.port()));
}

}  // namespace
}  // namespace caltwin
