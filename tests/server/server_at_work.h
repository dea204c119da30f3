#pragma once

#include <array>
#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tools/server/events.h"
#include "tools/server/server.h"

namespace caltwin {

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
class ServerAtWork {
 public:
  explicit ServerAtWork(ServerLimits limits = {}, std::size_t most_bytes = 100) {
    const auto add =
        [&](const char* method, const char* path, Route::Pace pace, Handler go) {
          routes_.Add({.method = method,
                       .pattern = path,
                       .handler = std::move(go),
                       .pace = pace,
                       .most_bytes = most_bytes});
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
  ~ServerAtWork() {
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

}  // namespace caltwin
