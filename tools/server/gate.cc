#include "tools/server/gate.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/crypto.h>

#include "sim/base/require.h"
#include "sim/base/text_file.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

constexpr std::string_view kCookie = "caltwin_token=";

// "localhost" of "localhost:8080", "::1" of "[::1]:8080".
std::string_view NameIn(std::string_view host) {
  if (host.starts_with('[')) {
    return host.substr(1, std::min(host.find(']'), host.size()) - 1);
  }
  return host.substr(0, host.find(':'));
}

bool IsThisComputer(std::string_view name) {
  return name == "localhost" || IsLoopback(std::string(name));
}

bool SameSecret(std::string_view one, std::string_view other) {
  return one.size() == other.size() &&
         CRYPTO_memcmp(one.data(), other.data(), one.size()) == 0;
}

// What a form's way of writing made of a '+' is one again: no token has a space.
std::string WithPlusses(std::string token) {
  std::ranges::replace(token, ' ', '+');
  return token;
}

// "http://shop.lan:8080", or as a proxy with TLS in front says that it was asked.
std::string OriginOf(const HttpRequest& request) {
  const std::string scheme = request.Header("x-forwarded-proto");
  return fmt::format("{}://{}",
                     scheme.empty() ? "http" : SmallLetters(scheme),
                     SmallLetters(request.Header("host")));
}

// What follows "Bearer"; empty: another scheme, or none.
std::string_view BearerIn(std::string_view authorization) {
  constexpr std::string_view kBearer = "bearer ";
  if (SmallLetters(authorization.substr(0, kBearer.size())) != kBearer) return {};
  authorization.remove_prefix(kBearer.size());
  authorization.remove_prefix(
      std::min(authorization.find_first_not_of(' '), authorization.size()));
  return authorization;
}

bool ChangesSomething(const std::string& method) {
  return method != "GET" && method != "HEAD" && method != "OPTIONS";
}

}  // namespace

bool IsLoopback(const std::string& address) {
  in_addr four{};
  // A whole address: "127.0.0.1.evil.example" is a name of somebody else's.
  const bool is_four = inet_pton(AF_INET, address.c_str(), &four) == 1;
  constexpr std::uint32_t kLoopbackNet = 127;
  return address == "::1" || address == "localhost" ||
         (is_four && ntohl(four.s_addr) >> 24 == kLoopbackNet);
}

Gate::Gate(std::string listens, std::string token)
    : listens_(std::move(listens)), token_(std::move(token)) {
  Require(!token_.empty() || IsLoopback(listens_),
          "an address that others reach has a token");
}

void Gate::Check(const HttpRequest& request) const {
  const std::string host = SmallLetters(request.Header("host"));
  if (token_.empty() && !IsThisComputer(NameIn(host))) {
    throw Problem(421,
                  fmt::format("this server is not '{}'", Printable(host)),
                  {{.detail = "it answers to localhost and 127.0.0.1 alone"}});
  }
  const std::string origin = SmallLetters(request.Header("origin"));
  const bool is_foreign = !origin.empty() && origin != OriginOf(request);
  const std::string site = request.Header("sec-fetch-site");
  const bool is_sent_by_another = site == "cross-site" || site == "same-site";
  const bool does_something =
      ChangesSomething(request.method) || request.path.starts_with("/api/");
  if (does_something && (is_foreign || is_sent_by_another)) {
    throw Problem(403,
                  fmt::format("a page of {} may not do this",
                              is_foreign ? Printable(origin) : "another site"));
  }
  if (!token_.empty() && !HasToken(request)) {
    throw Problem(
        401,
        "this server asks for its token",
        {{.detail = "no token, or another",
          .hint = "Authorization: Bearer TOKEN, or open /?token=TOKEN once"}});
  }
}

bool Gate::HasToken(const HttpRequest& request) const {
  const std::string given = request.Header("authorization");
  if (SameSecret(BearerIn(given), token_)) return true;
  std::string_view cookies = request.headers.contains("cookie")
                                 ? std::string_view(request.headers.at("cookie"))
                                 : std::string_view();
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view one = cookies.substr(0, end);
    one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
    if (one.starts_with(kCookie) && SameSecret(one.substr(kCookie.size()), token_)) {
      return true;
    }
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
  }
  return false;
}

bool Gate::IsEntrance(const HttpRequest& request) const {
  const auto given = request.query.find("token");
  return !token_.empty() && request.method == "GET" && request.path == "/" &&
         given != request.query.end() &&
         (SameSecret(given->second, token_) ||
          SameSecret(WithPlusses(given->second), token_));
}

HttpResponse Gate::Enter() const {
  return {
      .status = 302,
      .headers = {
          {"Location", "/"},
          {"Set-Cookie",
           fmt::format("{}{}; HttpOnly; SameSite=Strict; Path=/", kCookie, token_)}}};
}

}  // namespace caltwin
