#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "tools/server/gate.h"
#include "tools/server/routes.h"

namespace caltwin {

/// What bounds a server, so that no client stops it for others.
struct ServerLimits {
  /// At once; for a further one that closes which has waited longest for its client.
  int connections = 512;
  int streams = 384;  ///< Of events; further listeners get 503.
  int waiting = 64;   ///< Slow requests that run or wait; further ones get 503.
  int threads = 4;    ///< For slow requests.
  std::chrono::seconds to_begin{
      5};  ///< From its first byte the header has to be whole.
  std::chrono::seconds to_send{20};        ///< Then the body, and an answer taken.
  std::chrono::seconds idle{90};           ///< A kept connection without a request.
  std::size_t bodies_bytes = 192'000'000;  ///< Of all requests together (BodyBudget).
  std::size_t unsent_bytes = 4'000'000;    ///< Of an event stream nobody reads.
};

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;  ///< 0: any free one.
  ServerLimits limits{};
};

/// Serves `routes` over HTTP/1.1 until `*stop` is true, which it notices within a fifth
/// of a second. One thread reads and writes; slow routes have threads of their own. A
/// handler that is at work when the server stops is waited for.
///
/// `listening` is called once with the port. Throws InputError where address or port
/// cannot be had.
void ServeHttp(const Routes& routes,
               const Gate& gate,
               const ServerOptions& options,
               const std::atomic<bool>* stop,
               const std::function<void(int port)>& listening);

}  // namespace caltwin
