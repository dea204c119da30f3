#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace caltwin {

class EventTopic;

/// A request as read from the wire, its target taken apart.
struct HttpRequest {
  std::string method{};                          ///< "GET".
  std::string path{};                            ///< Decoded; begins with '/'.
  std::map<std::string, std::string> query{};    ///< Decoded; of doubles the last.
  std::map<std::string, std::string> headers{};  ///< Names in small letters.
  std::string body{};
  std::vector<std::string> places{};  ///< What stood for each {} of the route.

  /// The value of a header, empty where there is none; `name` in small letters.
  std::string Header(const std::string& name) const;
  /// Whether the client takes that type at least as gladly as `other`, by `Accept`.
  bool Prefers(std::string_view type, std::string_view other) const;
};

/// An answer. Where `events` is set, the body is what that topic publishes from now on.
struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  std::shared_ptr<EventTopic> events{};
};

/// A page of ours that loads nothing: style, script and pictures are inside.
HttpResponse PageResponse(std::string html);

/// Percent-decoded; nullopt where a sequence is broken or a zero byte comes out.
std::optional<std::string> PercentDecoded(std::string_view text);

/// Takes the target of a request line apart into `path` and `query`; false where it is
/// none, or names a folder above (`..`).
bool ReadTarget(std::string_view target, HttpRequest* request);

/// "Not Found" of 404.
std::string_view ReasonOf(int status);

/// Small letters of ASCII.
std::string SmallLetters(std::string_view text);

}  // namespace caltwin
