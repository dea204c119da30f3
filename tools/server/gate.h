#pragma once

#include <string>

#include "tools/server/http.h"

namespace caltwin {

/// Who may ask anything at all.
///
/// On a loopback address everybody on this computer, but no page of another site: the
/// name in `Host` has to be this computer's, and where a browser says of which page a
/// request is (`Origin`, `Sec-Fetch-Site`) it has to be ours, with its scheme: http, or
/// what a proxy in front says (`X-Forwarded-Proto`). On another address who
/// has the token: as `Authorization: Bearer`, or as a cookie that `/?token=` sets.
class Gate {
 public:
  /// @param listens  the address listened on
  /// @param token  empty: none is asked for, which only a loopback address may have
  Gate(std::string listens, std::string token);

  /// Throws Problem 421 (Host), 403 (another site), 401 (no token).
  void Check(const HttpRequest& request) const;
  /// Whether a request carries the token in its query: its answer sets the cookie and
  /// leads to the page without it.
  bool IsEntrance(const HttpRequest& request) const;
  HttpResponse Enter() const;

 private:
  bool HasToken(const HttpRequest& request) const;

  std::string listens_;
  std::string token_;
};

/// Whether only this computer reaches an address: 127.x.x.x, ::1.
bool IsLoopback(const std::string& address);

}  // namespace caltwin
