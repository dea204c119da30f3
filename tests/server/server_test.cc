#include "tools/server/server.h"

#include <atomic>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "tests/server/server_at_work.h"

namespace caltwin {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Server, OneConnectionIsAnsweredAgainAndAgain) {
  const ServerAtWork served;
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
  const ServerAtWork served;
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
  const ServerAtWork served;
  Client client(served.port());

  client.Say("GET /hello HTTP/1.1\r\nHost: localhost\r\nX: " +
             std::string(20'000, 'a') + "\r\n\r\n");

  EXPECT_THAT(client.Hear("never"), StartsWith("HTTP/1.1 431 "));
}

TEST(Server, EventsReachWhoListens) {
  ServerAtWork served;
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
  const ServerAtWork served;

  EXPECT_TRUE(IsRefused(served.port()));
}

}  // namespace
}  // namespace caltwin
