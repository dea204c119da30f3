#include "tools/server/server.h"

#include <memory>
#include <tuple>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "tools/server/connection.h"

namespace caltwin {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

void Accept(tcp::acceptor* acceptor, ConnectionTable* table) {
  acceptor->async_accept([acceptor, table](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error == asio::error::no_descriptors) table->MakeRoom();
    if (!error && table->HasRoom()) {
      error_code ignored;
      std::ignore = socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(std::move(socket), table)->Start();
    }
    Accept(acceptor, table);
  });
}

void WatchStop(asio::steady_timer* timer,
               asio::io_context* io,
               const std::atomic<bool>* stop) {
  timer->expires_after(std::chrono::milliseconds(100));
  timer->async_wait([timer, io, stop](error_code) {
    *stop ? io->stop() : WatchStop(timer, io, stop);
  });
}

tcp::acceptor ListenAt(const ServerOptions& options, asio::io_context* io) {
  try {
    const tcp::endpoint endpoint(asio::ip::make_address(options.address),
                                 static_cast<std::uint16_t>(options.port));
    tcp::acceptor acceptor(*io);
    acceptor.open(endpoint.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen(asio::socket_base::max_listen_connections);
    return acceptor;
  } catch (const boost::system::system_error& error) {
    throw InputError(
        {},
        fmt::format(
            "--http {}: {}: {}", options.port, options.address, error.code().message()),
        "--http 0 takes any free port; --listen says an address of this "
        "computer");
  }
}

}  // namespace

void ServeHttp(const Routes& routes,
               const Gate& gate,
               const ServerOptions& options,
               const std::atomic<bool>* stop,
               const std::function<void(int port)>& listening) {
  ConnectionTable table(routes, gate, options.limits);
  tcp::acceptor acceptor = ListenAt(options, &table.io);
  asio::steady_timer timer(table.io);
  WatchStop(&timer, &table.io, stop);
  Accept(&acceptor, &table);
  listening(acceptor.local_endpoint().port());
  table.io.run();
  table.workers.stop();  // What still waits is not begun.
  table.workers.join();
  for (Connection* const one : table.open) one->LeaveTopic();
}

}  // namespace caltwin
