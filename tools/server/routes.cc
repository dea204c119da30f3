#include "tools/server/routes.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

// What stands for each {} of the pattern; nullopt where the path is another.
std::optional<std::vector<std::string>> Matched(std::string_view pattern,
                                                std::string_view path) {
  std::vector<std::string> places;
  while (!pattern.empty() || !path.empty()) {
    const std::size_t pattern_end = std::min(pattern.find('/', 1), pattern.size());
    const std::size_t path_end = std::min(path.find('/', 1), path.size());
    const std::string_view asked = pattern.substr(0, pattern_end);
    const std::string_view given = path.substr(0, path_end);
    if (asked == "/{}" && given.size() > 1) {
      places.emplace_back(given.substr(1));
    } else if (asked != given) {
      return std::nullopt;
    }
    pattern.remove_prefix(pattern_end);
    path.remove_prefix(path_end);
  }
  return places;
}

}  // namespace

Route Routes::Find(HttpRequest* request) const {
  const std::string method = request->method == "HEAD" ? "GET" : request->method;
  for (const Route& route : routes_) {
    if (route.method != method) continue;
    if (auto places = Matched(route.pattern, request->path)) {
      request->places = *std::move(places);
      return route;
    }
  }
  const std::string allowed = Allowed(request->path);
  const bool is_of_pages = rest_ && !request->path.starts_with("/api/");
  if (allowed.empty() && is_of_pages && method == "GET") {
    return {.method = "GET", .handler = rest_};
  }
  if (!allowed.empty() || is_of_pages) {
    throw Problem(405,
                  fmt::format("{} does not take {}",
                              Printable(request->path),
                              Printable(request->method)));
  }
  throw Problem(
      404,
      fmt::format("nothing is at {}", Printable(request->path)),
      {{.detail = "no such path", .hint = "GET /api/openapi.json lists all"}});
}

std::string Routes::Allowed(std::string_view path) const {
  std::string allowed;
  for (const Route& route : routes_) {
    if (!Matched(route.pattern, path)) continue;
    if (!allowed.empty()) allowed += ", ";
    allowed += route.method == "GET" ? "GET, HEAD" : route.method;
  }
  return allowed;
}

HttpResponse AnswerOf(const Route& route, const HttpRequest& request) {
  try {
    return route.handler(request);
  } catch (const Problem& problem) {
    return problem.Response();
  } catch (const InputError& error) {
    return ProblemOf(error).Response();
  } catch (const std::exception& error) {
    fmt::print(stderr,
               "{} {}: {}\n",
               Printable(request.method),
               Printable(request.path),
               Printable(error.what()));
    return Problem(500, "the server made a mistake; its terminal says which")
        .Response();
  }
}

}  // namespace caltwin
