#include "tools/server/http.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace caltwin {
namespace {

struct Reason {
  int status;
  std::string_view text;
};
constexpr std::array kReasons = {Reason{200, "OK"},
                                 Reason{201, "Created"},
                                 Reason{202, "Accepted"},
                                 Reason{204, "No Content"},
                                 Reason{302, "Found"},
                                 Reason{304, "Not Modified"},
                                 Reason{400, "Bad Request"},
                                 Reason{401, "Unauthorized"},
                                 Reason{403, "Forbidden"},
                                 Reason{404, "Not Found"},
                                 Reason{405, "Method Not Allowed"},
                                 Reason{406, "Not Acceptable"},
                                 Reason{408, "Request Timeout"},
                                 Reason{409, "Conflict"},
                                 Reason{413, "Content Too Large"},
                                 Reason{415, "Unsupported Media Type"},
                                 Reason{421, "Misdirected Request"},
                                 Reason{422, "Unprocessable Content"},
                                 Reason{429, "Too Many Requests"},
                                 Reason{431, "Request Header Fields Too Large"},
                                 Reason{500, "Internal Server Error"},
                                 Reason{502, "Bad Gateway"},
                                 Reason{503, "Service Unavailable"},
                                 Reason{504, "Gateway Timeout"}};

// The quality that `Accept` gives a type: 0 where it is not named at all.
double QualityOf(std::string_view accept, std::string_view type) {
  double best = 0;
  const std::string family = std::string(type.substr(0, type.find('/'))) + "/*";
  while (!accept.empty()) {
    const std::size_t comma = std::min(accept.find(','), accept.size());
    const std::string entry = SmallLetters(accept.substr(0, comma));
    accept.remove_prefix(std::min(comma + 1, accept.size()));
    const std::size_t from = entry.find_first_not_of(" \t");
    if (from == std::string::npos) continue;
    const std::size_t to = std::min(entry.find_first_of("; \t", from), entry.size());
    const std::string_view named = std::string_view(entry).substr(from, to - from);
    if (named != type && named != family && named != "*/*") continue;
    double quality = 1;
    if (const std::size_t at = entry.find("q="); at != std::string::npos) {
      std::from_chars(entry.data() + at + 2, entry.data() + entry.size(), quality);
    }
    best = std::max(best, quality);
  }
  return best;
}

bool ReadQuery(std::string_view text, std::map<std::string, std::string>* query) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('&'), text.size());
    std::string pair(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::ranges::replace(pair, '+', ' ');
    const std::size_t equals = std::min(pair.find('='), pair.size());
    const auto key = PercentDecoded(pair.substr(0, equals));
    const auto value = PercentDecoded(pair.substr(std::min(equals + 1, pair.size())));
    if (!key || !value) return false;
    if (!key->empty()) (*query)[*key] = *value;
  }
  return true;
}

bool ClimbsUp(std::string_view path) {
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    if (path.substr(0, end) == "..") return true;
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return false;
}

}  // namespace

std::string HttpRequest::Header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

bool HttpRequest::Prefers(std::string_view type, std::string_view other) const {
  const std::string accept = Header("accept");
  if (accept.empty()) return false;
  const double quality = QualityOf(accept, type);
  return quality > 0 && quality >= QualityOf(accept, other) &&
         accept.find(type) != std::string::npos;
}

HttpResponse PageResponse(std::string html) {
  return {.content_type = "text/html; charset=utf-8",
          .body = std::move(html),
          .headers = {{"Content-Security-Policy",
                       "default-src 'none'; style-src 'unsafe-inline'; script-src "
                       "'unsafe-inline'; img-src data:"}}};
}

std::optional<std::string> PercentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    unsigned value = 0;
    const char* const from = text.data() + i + 1;
    if (i + 2 >= text.size()) return std::nullopt;  // Two digits follow.
    const auto [end, error] = std::from_chars(from, from + 2, value, 16);
    if (error != std::errc() || end != from + 2 || value == 0) return std::nullopt;
    decoded += static_cast<char>(value);
    i += 2;
  }
  return decoded;
}

bool ReadTarget(std::string_view target, HttpRequest* request) {
  if (const std::size_t hash = target.find('#'); hash != std::string_view::npos) {
    target = target.substr(0, hash);
  }
  const std::size_t mark = std::min(target.find('?'), target.size());
  const auto path = PercentDecoded(target.substr(0, mark));
  if (!path || !path->starts_with('/') || ClimbsUp(*path)) return false;
  request->path = *path;
  return ReadQuery(target.substr(std::min(mark + 1, target.size())), &request->query);
}

std::string_view ReasonOf(int status) {
  const auto* const found = std::ranges::find(kReasons, status, &Reason::status);
  return found == kReasons.end() ? "Unknown" : found->text;
}

std::string SmallLetters(std::string_view text) {
  std::string small(text);
  for (char& letter : small) {
    if (letter >= 'A' && letter <= 'Z')
      letter = static_cast<char>(letter + ('a' - 'A'));
  }
  return small;
}

}  // namespace caltwin
