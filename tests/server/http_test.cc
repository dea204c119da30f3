#include "tools/server/http.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

HttpRequest Read(const std::string& target) {
  HttpRequest request;
  EXPECT_TRUE(ReadTarget(target, &request)) << target;
  return request;
}

bool IsRefused(const std::string& target) {
  HttpRequest request;
  return !ReadTarget(target, &request);
}

TEST(Http, ATargetIsAPathAndAQuery) {
  const HttpRequest request = Read("/api/runs/7?for=rrf&name=a%20b+c&empty=&flag#part");

  EXPECT_EQ(request.path, "/api/runs/7");
  EXPECT_EQ(request.query.at("for"), "rrf");
  EXPECT_EQ(request.query.at("name"), "a b c");
  EXPECT_EQ(request.query.at("empty"), "");
  EXPECT_EQ(request.query.at("flag"), "");
}

TEST(Http, NoTargetClimbsAboveItsFolder) {
  EXPECT_TRUE(IsRefused("/../etc/passwd"));
  EXPECT_TRUE(IsRefused("/a/..%2f..%2fetc/passwd"));
  EXPECT_TRUE(IsRefused("/%2e%2e/etc/passwd"));
  EXPECT_FALSE(IsRefused("/a..b/c"));
}

TEST(Http, BrokenTargetsAreRefused) {
  EXPECT_TRUE(IsRefused(""));
  EXPECT_TRUE(IsRefused("api"));
  EXPECT_TRUE(IsRefused("http://other/"));
  EXPECT_TRUE(IsRefused("/%"));
  EXPECT_TRUE(IsRefused("/%4"));
  EXPECT_TRUE(IsRefused("/%zz"));
  EXPECT_TRUE(IsRefused("/%00"));
  EXPECT_TRUE(IsRefused("/?a=%g1"));
}

TEST(Http, AcceptDecidesBetweenTypes) {
  HttpRequest request;
  const auto prefers = [&](const std::string& accept) {
    request.headers["accept"] = accept;
    return request.Prefers("application/json", "text/html");
  };

  EXPECT_TRUE(prefers("application/json"));
  EXPECT_TRUE(prefers("application/json, text/html;q=0.5"));
  EXPECT_FALSE(prefers("text/html, application/json;q=0.9"));
  EXPECT_FALSE(prefers("*/*"));
  EXPECT_FALSE(prefers("application/json;q=0"));
  request.headers.clear();
  EXPECT_FALSE(request.Prefers("application/json", "text/html"));
}

}  // namespace
}  // namespace caltwin
