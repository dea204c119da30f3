#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/server/http.h"

namespace caltwin {

/// Answers a request; throws Problem or InputError.
using Handler = std::function<HttpResponse(const HttpRequest&)>;

/// @name How large bodies may be
inline constexpr std::size_t kMostJson_bytes = 1'000'000;
inline constexpr std::size_t kMostUpload_bytes = 64'000'000;

/// One thing that a server does.
struct Route {
  enum class Pace {
    kQuick,  ///< At once, on the thread that reads and writes: no waiting in there.
    kSlow    ///< In a thread of its own.
  };
  std::string method{};
  std::string pattern{};  ///< "/api/runs/{}/report": {} is one part of the path.
  Handler handler{};
  Pace pace = Pace::kQuick;
  std::size_t most_bytes = kMostJson_bytes;  ///< Of the body.
};

/// What a server does, by method and path.
class Routes {
 public:
  void Add(Route route) { routes_.push_back(std::move(route)); }
  /// What answers GET and HEAD of every other path (the pages); none: 404.
  void SetRest(Handler rest) { rest_ = std::move(rest); }

  /// The route of a request, its `places` filled; throws Problem 404 or 405 (with
  /// `Allow`, told by Allowed). HEAD is answered by the route of GET.
  Route Find(HttpRequest* request) const;
  /// "GET, HEAD, POST" of a path; empty where nothing is there.
  std::string Allowed(std::string_view path) const;

 private:
  std::vector<Route> routes_{};
  Handler rest_{};
};

/// Answers, whatever the handler throws.
HttpResponse AnswerOf(const Route& route, const HttpRequest& request);

}  // namespace caltwin
