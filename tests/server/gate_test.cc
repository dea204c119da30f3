#include "tools/server/gate.h"

#include <gtest/gtest.h>

#include "tools/server/problem.h"

namespace caltwin {
namespace {

HttpRequest Asked(const std::string& method,
                  std::map<std::string, std::string> headers) {
  headers.try_emplace("host", "localhost:8080");
  return {.method = method, .path = "/api", .headers = std::move(headers)};
}

int StatusOf(const Gate& gate, const HttpRequest& request) {
  try {
    gate.Check(request);
  } catch (const Problem& problem) {
    return problem.status();
  }
  return 200;
}

TEST(Gate, OnlyThisComputersNamesAreAnswered) {
  const Gate gate("127.0.0.1", "");

  for (const char* host :
       {"localhost:8080", "127.0.0.1:8080", "[::1]:8080", "LOCALHOST"}) {
    EXPECT_EQ(StatusOf(gate, Asked("GET", {{"host", host}})), 200) << host;
  }
  // A page of evil.example that lets its name lead here.
  for (const char* host : {"evil.example:8080",
                           "localhost.evil.example",
                           "127.0.0.1.evil.example",
                           "127.evil.example",
                           ""}) {
    EXPECT_EQ(StatusOf(gate, Asked("GET", {{"host", host}})), 421) << host;
  }
}

TEST(Gate, APageOfAnotherSiteChangesNothing) {
  const Gate gate("127.0.0.1", "");

  EXPECT_EQ(StatusOf(gate, Asked("POST", {})), 200);
  EXPECT_EQ(StatusOf(gate, Asked("POST", {{"origin", "http://localhost:8080"}})), 200);
  EXPECT_EQ(StatusOf(gate, Asked("POST", {{"origin", "http://evil.example"}})), 403);
  EXPECT_EQ(StatusOf(gate, Asked("POST", {{"origin", "http://localhost:9"}})), 403);
  EXPECT_EQ(StatusOf(gate, Asked("POST", {{"origin", "https://localhost:8080"}})), 403);
  EXPECT_EQ(StatusOf(gate, Asked("DELETE", {{"origin", "null"}})), 403);
  EXPECT_EQ(StatusOf(gate, Asked("PATCH", {{"sec-fetch-site", "cross-site"}})), 403);
  EXPECT_EQ(StatusOf(gate, Asked("POST", {{"sec-fetch-site", "same-origin"}})), 200);
}

TEST(Gate, AProxyWithTlsInFrontSaysHowItWasAsked) {
  const Gate gate("127.0.0.1", "");

  EXPECT_EQ(StatusOf(gate,
                     Asked("POST",
                           {{"origin", "https://localhost:8080"},
                            {"x-forwarded-proto", "https"}})),
            200);
  EXPECT_EQ(StatusOf(gate,
                     Asked("POST",
                           {{"origin", "http://localhost:8080"},
                            {"x-forwarded-proto", "https"}})),
            403);
}

TEST(Gate, OthersNeedTheToken) {
  const Gate gate("0.0.0.0", "sixteen-letters!");
  const auto with = [](const char* name, const std::string& value) {
    return Asked("GET", {{"host", "shop.lan:8080"}, {name, value}});
  };

  EXPECT_EQ(StatusOf(gate, with("x", "y")), 401);
  EXPECT_EQ(StatusOf(gate, with("authorization", "Bearer sixteen-letters!")), 200);
  EXPECT_EQ(StatusOf(gate, with("authorization", "Bearer sixteen-letters?")), 401);
  EXPECT_EQ(StatusOf(gate, with("authorization", "bearer sixteen-letters!")), 200);
  EXPECT_EQ(StatusOf(gate, with("authorization", "BEARER  sixteen-letters!")), 200);
  EXPECT_EQ(StatusOf(gate, with("authorization", "Basic sixteen-letters!")), 401);
  EXPECT_EQ(StatusOf(gate, with("authorization", "Bearer ")), 401);
  EXPECT_EQ(StatusOf(gate, with("authorization", "Bearer")), 401);
  EXPECT_EQ(StatusOf(gate, with("cookie", "a=b; caltwin_token=sixteen-letters!")), 200);
  EXPECT_EQ(StatusOf(gate, with("cookie", "xcaltwin_token=sixteen-letters!")), 401);
}

TEST(Gate, TheTokenInTheAddressSetsACookie) {
  const Gate gate("0.0.0.0", "sixteen-letters!");
  HttpRequest request{
      .method = "GET", .path = "/", .query = {{"token", "sixteen-letters!"}}};

  EXPECT_TRUE(gate.IsEntrance(request));
  EXPECT_EQ(gate.Enter().status, 302);
  request.query["token"] = "another";
  EXPECT_FALSE(gate.IsEntrance(request));
}

// A form's way of writing makes a space of it on the wire.
TEST(Gate, APlusInTheTokenIsTakenAsItIs) {
  const Gate gate("0.0.0.0", "sixteen+letters+");
  for (const char* const target :
       {"/?token=sixteen+letters+", "/?token=sixteen%2Bletters%2B"}) {
    HttpRequest request{.method = "GET"};
    ASSERT_TRUE(ReadTarget(target, &request));
    EXPECT_TRUE(gate.IsEntrance(request)) << target;
  }
}

TEST(Gate, NoOpenAddressWithoutAToken) {
  EXPECT_THROW(Gate("0.0.0.0", ""), std::logic_error);
}

}  // namespace
}  // namespace caltwin
