#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include "tools/server/body_budget.h"
#include "tools/server/events.h"
#include "tools/server/gate.h"
#include "tools/server/problem.h"
#include "tools/server/routes.h"
#include "tools/server/server.h"

namespace caltwin {

class Connection;

/// All connections of a server, and what they share. Touched on the one thread of `io`
/// alone, but for the workers and what is handed to `io`.
class ConnectionTable {
 public:
  ConnectionTable(const Routes& routes, const Gate& gate, const ServerLimits& limits);

  /// Whether there is room for one more. A full table makes some: the connection closes
  /// that has waited longest without having completed a request, be it that one was
  /// begun or none. What is at work, and who listens to events, stays; both are so few
  /// (ServerLimits) that they never fill the table.
  bool HasRoom();
  /// As HasRoom on a full table: where the computer has no more sockets.
  bool MakeRoom();

  const Routes& routes;
  const Gate& gate;
  const ServerLimits& limits;
  std::set<Connection*> open{};
  std::uint64_t last_turn = 0;  ///< See Connection::turn().
  int waiting = 0;              ///< Slow requests.
  int streams = 0;
  BodyBudget bodies;
  boost::asio::io_context io{1};  ///< Below what its handlers touch as they end.
  boost::asio::thread_pool workers;
};

/// One client. Reads a request, has it answered, writes, and again; all but slow
/// handlers on the thread of `io`.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(boost::asio::ip::tcp::socket socket, ConnectionTable* table);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  void Start() { ReadHeader(); }
  void Close();
  /// No event comes from now on.
  void LeaveTopic();

  /// Whether the client makes us wait, not we the client.
  bool is_waiting() const { return stage_ == Stage::kWaiting; }
  /// Since when it waits, as a number that grows.
  std::uint64_t turn() const { return turn_; }

 private:
  using error_code = boost::system::error_code;
  enum class Stage {
    kWaiting,  ///< For a request or the rest of it, or that an answer is taken.
    kAtWork,   ///< In a slow handler.
    kStreaming
  };

  void WaitFrom(Stage stage);

  /// @name A request
  void ReadHeader();
  void ReadMoreOfHeader();
  void ParseHeader();
  void HeaderRead(error_code error);
  Route RouteOf(HttpRequest* request) const;
  void Continue();
  void ReadBody();
  void BodyRead(error_code error);

  /// @name Its answer
  void Handle();
  void Refuse(const Problem& problem);
  void RefuseLength();
  void RefuseBusy(const std::string& why);
  void Send(const HttpResponse& response);
  void Written(error_code error);
  void Drain();
  void ReleaseBody();

  /// @name An event stream
  void Stream(const std::shared_ptr<EventTopic>& topic);
  void Push(const std::string& text);
  void WriteUnsent();
  void Beat();
  void NoticeEnd();

  boost::beast::tcp_stream stream_;
  ConnectionTable* table_;
  Stage stage_ = Stage::kWaiting;
  std::uint64_t turn_ = 0;
  BodyBudget::Share body_;
  boost::asio::steady_timer heartbeat_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>>
      parser_{};
  HttpRequest request_{};
  Route route_{};
  bool keeps_ = true;
  bool is_idle_ = false;     ///< Between two requests: no byte of the next is here.
  bool is_refused_ = false;  ///< The rest of its request is not read.
  std::shared_ptr<EventTopic> topic_{};
  int listener_ = 0;
  std::deque<std::string> unsent_{};
  std::size_t unsent_bytes_ = 0;
};

}  // namespace caltwin
