#include <chrono>
#include <deque>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/server_at_work.h"

namespace caltwin {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr std::chrono::hours kNever{1};
const std::string kHello = "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n";

// So long that no deadline helps.
ServerLimits Few(int connections) {
  return {.connections = connections,
          .streams = 2,
          .to_begin = kNever,
          .to_send = kNever,
          .idle = kNever};
}

// Connections that wait, each of which said `said`.
std::deque<Client> Crowd(const ServerAtWork& served,
                         int count,
                         const std::string& said) {
  std::deque<Client> crowd;
  for (int i = 0; i < count; ++i) crowd.emplace_back(served.port()).Say(said);
  return crowd;
}

std::string Upload(int length) {
  return "POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
         std::to_string(length) + "\r\n\r\n";
}

TEST(Server, RequestsThatNeverEndGiveWayToANewcomer) {
  const ServerAtWork served(Few(8));
  for (const char* const begun :
       {"",
        "GET /hel",
        "POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n"}) {
    std::deque<Client> crowd = Crowd(served, 20, begun);

    Client client(served.port());
    client.Say(kHello);

    EXPECT_THAT(client.Hear("hello"), StartsWith("HTTP/1.1 200 OK")) << begun;
    EXPECT_THAT(crowd.front().Hear("never"), IsEmpty()) << begun;
  }
}

TEST(Server, ConnectionsKeptForLaterGiveWayToANewcomer) {
  const ServerAtWork served(Few(8));
  std::deque<Client> crowd = Crowd(served, 8, kHello);
  for (Client& one : crowd) EXPECT_THAT(one.Hear("hello"), HasSubstr(" 200 "));

  Client client(served.port());
  client.Say(kHello);

  EXPECT_THAT(client.Hear("hello"), StartsWith("HTTP/1.1 200 OK"));
  crowd.back().Say(kHello);
  EXPECT_THAT(crowd.back().Hear("hello"), HasSubstr(" 200 ")) << "the last one stays";
}

TEST(Server, ListenersStayWhateverElseComes) {
  ServerAtWork served(Few(8));
  const std::string ask = "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n";
  std::deque<Client> listeners = Crowd(served, 2, ask);
  for (Client& one : listeners) EXPECT_THAT(one.Hear("retry"), HasSubstr(" 200 "));
  Client third(served.port());
  third.Say(ask);
  const std::string refused = third.Hear("}");
  EXPECT_THAT(refused, StartsWith("HTTP/1.1 503 "));
  EXPECT_THAT(refused, HasSubstr("Retry-After: 2"));

  const std::deque<Client> crowd = Crowd(served, 40, "GET /hel");
  Client client(served.port());
  client.Say(kHello);
  EXPECT_THAT(client.Hear("hello"), HasSubstr(" 200 "));
  served.topic().Publish("touch", "{}");

  for (Client& one : listeners) EXPECT_THAT(one.Hear("touch"), HasSubstr("touch"));
}

TEST(Server, UploadsTogetherAreBounded) {
  ServerLimits limits;
  limits.bodies_bytes = 300'000;
  const ServerAtWork served(limits, 1'000'000);
  Client first(served.port());
  first.Say(Upload(200'000));
  Client chunks(served.port());
  chunks.Say(
      "POST /echo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
  constexpr int kChunks = 4;
  for (int i = 0; i < kChunks; ++i) {
    chunks.Say("c350\r\n" + std::string(50'000, 'a') + "\r\n");
  }

  const std::string too_much = chunks.Hear("}");
  Client second(served.port());
  second.Say(Upload(200'000));
  const std::string refused = second.Hear("}");
  Client small(served.port());
  small.Say(Upload(3) + "abc");

  for (const std::string& one : {too_much, refused}) {
    EXPECT_THAT(one, StartsWith("HTTP/1.1 503 "));
    EXPECT_THAT(one, HasSubstr("Retry-After: 2"));
    EXPECT_THAT(one, HasSubstr("application/problem+json"));
  }
  EXPECT_THAT(small.Hear("<abc>"), HasSubstr(" 200 "));
  first.Say(std::string(200'000, 'a'));
  EXPECT_THAT(first.Hear("a>"), HasSubstr(" 200 "));
  Client third(served.port());
  third.Say(Upload(200'000) + std::string(200'000, 'b'));
  EXPECT_THAT(third.Hear("b>"), HasSubstr(" 200 "))
      << "what was answered is free again";
}

}  // namespace
}  // namespace caltwin
