#include "tools/server/routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/input_error.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

using testing::ElementsAre;

Routes Some() {
  Routes routes;
  const Handler echo = [](const HttpRequest& r) {
    return HttpResponse{.body = r.path};
  };
  routes.Add({.method = "GET", .pattern = "/api/runs", .handler = echo});
  routes.Add({.method = "POST", .pattern = "/api/runs", .handler = echo});
  routes.Add({.method = "GET", .pattern = "/api/runs/{}/report", .handler = echo});
  return routes;
}

int StatusOf(const Routes& routes, const std::string& method, const std::string& path) {
  HttpRequest request{.method = method, .path = path};
  try {
    routes.Find(&request);
  } catch (const Problem& problem) {
    return problem.status();
  }
  return 200;
}

TEST(Routes, APatternNamesParts) {
  HttpRequest request{.method = "GET", .path = "/api/runs/17/report"};

  Some().Find(&request);

  EXPECT_THAT(request.places, ElementsAre("17"));
}

TEST(Routes, WhatIsNotThereSaysSo) {
  const Routes routes = Some();

  EXPECT_EQ(StatusOf(routes, "GET", "/api/runs"), 200);
  EXPECT_EQ(StatusOf(routes, "HEAD", "/api/runs"), 200);
  EXPECT_EQ(StatusOf(routes, "DELETE", "/api/runs"), 405);
  EXPECT_EQ(routes.Allowed("/api/runs"), "GET, HEAD, POST");
  EXPECT_EQ(StatusOf(routes, "GET", "/api/runs/"), 404);
  EXPECT_EQ(StatusOf(routes, "GET", "/api/runs//report"), 404);
  EXPECT_EQ(StatusOf(routes, "GET", "/api/runs/1/report/x"), 404);
  EXPECT_EQ(StatusOf(routes, "GET", "/else"), 404);
}

TEST(Routes, PagesAnswerWhatIsNoneOfTheRest) {
  Routes routes = Some();
  routes.SetRest([](const HttpRequest&) { return HttpResponse{.body = "page"}; });

  EXPECT_EQ(StatusOf(routes, "GET", "/bed"), 200);
  EXPECT_EQ(StatusOf(routes, "POST", "/bed"), 405);
  EXPECT_EQ(StatusOf(routes, "GET", "/api/else"), 404);
}

TEST(Routes, WhateverAHandlerThrowsIsAnswered) {
  const auto answered = [](const Handler& handler) {
    return AnswerOf({.handler = handler}, {.method = "GET", .path = "/"});
  };
  const HttpResponse bad = answered([](const HttpRequest&) -> HttpResponse {
    throw InputError(
        {.file = "x.csv", .line = 3, .column = 7}, "'a' is no number", "a hint");
  });
  const auto tree = nlohmann::json::parse(bad.body);

  EXPECT_EQ(bad.status, 422);
  EXPECT_EQ(bad.content_type, "application/problem+json");
  EXPECT_EQ(tree["detail"], "'a' is no number");
  EXPECT_EQ(tree["errors"][0]["file"], "x.csv");
  EXPECT_EQ(tree["errors"][0]["line"], 3);
  EXPECT_EQ(tree["errors"][0]["column"], 7);
  EXPECT_EQ(tree["errors"][0]["hint"], "a hint");
  EXPECT_EQ(answered([](const HttpRequest&) -> HttpResponse {
              throw std::runtime_error("ours");
            }).status,
            500);
}

}  // namespace
}  // namespace caltwin
