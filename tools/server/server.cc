#include "tools/server/server.h"

#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "tools/server/events.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::uint32_t kMostHeader_bytes = 16'384;
constexpr std::size_t kBuffer_bytes = 65'536;
constexpr std::chrono::seconds kHeartbeat{15};  // Of an event stream that says nothing.

class Connection;

// What connections share.
struct Shared {
  const Routes& routes;
  const Gate& gate;
  const ServerLimits& limits;
  int connections = 0;  // Touched on the one thread of `io` alone.
  int waiting = 0;      // Likewise, and what follows.
  std::set<Connection*> streams{};
  asio::io_context io{1};
  asio::thread_pool workers;
};

HttpRequest ReadRequest(const http::request<http::string_body>& message,
                        bool* is_sound) {
  HttpRequest request{.method = std::string(message.method_string())};
  for (const auto& field : message) {
    std::string& value = request.headers[SmallLetters(
        {field.name_string().data(), field.name_string().size()})];
    if (!value.empty()) value += ", ";
    value += std::string(field.value());
  }
  *is_sound = ReadTarget({message.target().data(), message.target().size()}, &request);
  return request;
}

// One client. Reads a request, has it answered, writes, and again; all but slow
// handlers on the thread of `io`.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Shared* shared)
      : stream_(std::move(socket)), shared_(shared), heartbeat_(shared->io) {
    ++shared_->connections;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    LeaveTopic();
    --shared_->connections;
  }

  void Start() { ReadHeader(); }
  // No event comes from now on.
  void LeaveTopic() {
    if (topic_) topic_->Leave(listener_);
    topic_.reset();
    shared_->streams.erase(this);
  }

 private:
  void ReadHeader() {
    parser_.emplace();
    parser_->header_limit(kMostHeader_bytes);
    parser_->body_limit(boost::none);
    stream_.expires_after(is_first_ ? shared_->limits.to_send : shared_->limits.idle);
    is_first_ = false;
    http::async_read_header(stream_,
                            buffer_,
                            *parser_,
                            [self = shared_from_this()](error_code error, auto) {
                              self->HeaderRead(error);
                            });
  }

  void HeaderRead(error_code error) {
    if (error == http::error::header_limit) {
      return Refuse(Problem(431, "the headers are longer than 16 kB"));
    }
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      return Refuse(Problem(400, "this is no HTTP request: " + error.message()));
    }
    if (error) return Close();
    bool is_sound = false;
    request_ = ReadRequest(parser_->get(), &is_sound);
    if (!is_sound) return Refuse(Problem(400, "the target is no path of this server"));
    try {
      if (!shared_->gate.IsEntrance(request_)) shared_->gate.Check(request_);
      route_ = RouteOf(&request_);
    } catch (const Problem& problem) {
      return Refuse(problem);
    }
    const auto length = parser_->content_length();
    if (length && *length > route_.most_bytes) return RefuseLength();
    parser_->body_limit(route_.most_bytes);
    if (SmallLetters(request_.Header("expect")) == "100-continue") return Continue();
    ReadBody();
  }

  Route RouteOf(HttpRequest* request) const {
    if (shared_->gate.IsEntrance(*request)) {
      return {.handler = [this](const HttpRequest&) {
        return shared_->gate.Enter();
      }};
    }
    if (request->method == "OPTIONS") {
      const std::string allowed = shared_->routes.Allowed(request->path);
      return {.handler = [allowed](const HttpRequest&) {
        return HttpResponse{.status = 204, .headers = {{"Allow", allowed}}};
      }};
    }
    return shared_->routes.Find(request);
  }

  void RefuseLength() {
    Refuse(Problem(413,
                   fmt::format("a body here is at most {} bytes", route_.most_bytes)));
  }

  void Continue() {
    static constexpr std::string_view kGoOn = "HTTP/1.1 100 Continue\r\n\r\n";
    asio::async_write(stream_,
                      asio::buffer(kGoOn),
                      [self = shared_from_this()](error_code error, auto) {
                        error ? self->Close() : self->ReadBody();
                      });
  }

  void ReadBody() {
    stream_.expires_after(shared_->limits.to_send);
    http::async_read(stream_,
                     buffer_,
                     *parser_,
                     [self = shared_from_this()](error_code error, auto) {
                       if (error == http::error::body_limit)
                         return self->RefuseLength();
                       if (error) return self->Close();
                       self->request_.body = std::move(self->parser_->get().body());
                       self->Handle();
                     });
  }

  void Handle() {
    keeps_ = parser_->get().keep_alive();
    if (route_.pace == Route::Pace::kQuick) return Send(AnswerOf(route_, request_));
    if (shared_->waiting >= shared_->limits.waiting) {
      HttpResponse busy = Problem(503, "the server is busy: try again").Response();
      busy.headers.emplace_back("Retry-After", "2");
      return Send(busy);
    }
    ++shared_->waiting;
    stream_.expires_never();
    asio::post(shared_->workers, [self = shared_from_this()]() mutable {
      auto answer =
          std::make_shared<HttpResponse>(AnswerOf(self->route_, self->request_));
      Shared* const shared = self->shared_;
      // The connection goes along: it ends on the thread of `io` alone.
      asio::post(shared->io, [self = std::move(self), answer] {
        --self->shared_->waiting;
        self->Send(*answer);
      });
    });
  }

  // Answers and closes: what follows on the wire may be the rest of a body.
  void Refuse(const Problem& problem) {
    keeps_ = false;
    HttpResponse response = problem.Response();
    if (problem.status() == 405) {
      response.headers.emplace_back("Allow", shared_->routes.Allowed(request_.path));
    }
    if (problem.status() == 401)
      response.headers.emplace_back("WWW-Authenticate", "Bearer");
    Send(response);
  }

  void Send(const HttpResponse& response) {
    if (response.events) return Stream(response.events);
    auto message = std::make_shared<http::response<http::string_body>>();
    message->version(11);
    message->result(static_cast<unsigned>(response.status));
    message->reason(std::string(ReasonOf(response.status)));
    message->set(http::field::server, "caltwin");
    message->set("X-Content-Type-Options", "nosniff");
    message->set("Referrer-Policy", "no-referrer");
    message->set(http::field::cache_control, "no-store");
    for (const auto& [name, value] : response.headers) message->set(name, value);
    const bool has_body = response.status != 204 && response.status != 304;
    if (has_body) message->set(http::field::content_type, response.content_type);
    message->keep_alive(keeps_);
    message->body() = has_body ? response.body : "";
    if (has_body) message->prepare_payload();
    if (request_.method == "HEAD") message->body().clear();
    stream_.expires_after(shared_->limits.to_send);
    http::async_write(stream_,
                      *message,
                      [self = shared_from_this(), message](error_code error, auto) {
                        if (error || !self->keeps_) return self->Close();
                        self->request_ = {};
                        self->ReadHeader();
                      });
  }

  void Stream(const std::shared_ptr<EventTopic>& topic) {
    unsent_.push_back(
        "HTTP/1.1 200 OK\r\nServer: caltwin\r\nContent-Type: text/event-stream\r\n"
        "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
        "Connection: close\r\n\r\nretry: 2000\n\n");
    if (request_.method == "HEAD") return WriteUnsent();
    stream_.expires_never();
    topic_ = topic;
    shared_->streams.insert(this);
    std::uint64_t since = topic->last();
    const std::string last = request_.Header("last-event-id");
    const auto asked = request_.query.find("since");
    const std::string& from =
        last.empty() && asked != request_.query.end() ? asked->second : last;
    if (!from.empty()) since = std::strtoull(from.c_str(), nullptr, 10);
    const std::weak_ptr<Connection> weak = weak_from_this();
    listener_ = topic->Listen(since, [weak, shared = shared_](const std::string& text) {
      asio::post(shared->io, [weak, text] {
        if (const auto self = weak.lock()) self->Push(text);
      });
    });
    WriteUnsent();
    Beat();
    NoticeEnd();
  }

  void Push(const std::string& text) {
    if (!stream_.socket().is_open()) return;
    unsent_bytes_ += text.size();
    if (unsent_bytes_ > shared_->limits.unsent_bytes) return Close();
    unsent_.push_back(text);
    if (unsent_.size() == 1) WriteUnsent();
  }

  void WriteUnsent() {
    asio::async_write(stream_,
                      asio::buffer(unsent_.front()),
                      [self = shared_from_this()](error_code error, auto) {
                        if (error || self->request_.method == "HEAD")
                          return self->Close();
                        self->unsent_bytes_ -=
                            std::min(self->unsent_bytes_, self->unsent_.front().size());
                        self->unsent_.pop_front();
                        if (!self->unsent_.empty()) self->WriteUnsent();
                      });
  }

  void Beat() {
    heartbeat_.expires_after(kHeartbeat);
    heartbeat_.async_wait([weak = weak_from_this()](error_code error) {
      const auto self = weak.lock();
      if (error || !self || !self->stream_.socket().is_open()) return;
      self->Push(":\n\n");
      self->Beat();
    });
  }

  // A listener says nothing more: what is read is its end.
  void NoticeEnd() {
    stream_.async_read_some(buffer_.prepare(512),
                            [self = shared_from_this()](error_code error, auto) {
                              error ? self->Close() : self->NoticeEnd();
                            });
  }

  void Close() {
    heartbeat_.cancel();
    error_code ignored;
    std::ignore = stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
    std::ignore = stream_.socket().close(ignored);
  }

  beast::tcp_stream stream_;
  Shared* shared_;
  asio::steady_timer heartbeat_;
  beast::flat_buffer buffer_{kBuffer_bytes};
  std::optional<http::request_parser<http::string_body>> parser_{};
  HttpRequest request_{};
  Route route_{};
  bool keeps_ = true;
  bool is_first_ = true;
  /// @name Of an event stream
  std::shared_ptr<EventTopic> topic_{};
  int listener_ = 0;
  std::deque<std::string> unsent_{};
  std::size_t unsent_bytes_ = 0;
};

void Accept(tcp::acceptor* acceptor, Shared* shared) {
  acceptor->async_accept([acceptor, shared](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && shared->connections < shared->limits.connections) {
      error_code ignored;
      std::ignore = socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(std::move(socket), shared)->Start();
    }
    Accept(acceptor, shared);
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
  Shared shared{
      .routes = routes,
      .gate = gate,
      .limits = options.limits,
      .workers = asio::thread_pool(static_cast<std::size_t>(options.limits.threads))};
  tcp::acceptor acceptor = ListenAt(options, &shared.io);
  asio::steady_timer timer(shared.io);
  WatchStop(&timer, &shared.io, stop);
  Accept(&acceptor, &shared);
  listening(acceptor.local_endpoint().port());
  shared.io.run();
  shared.workers.stop();  // What still waits is not begun.
  shared.workers.join();
  while (!shared.streams.empty()) (*shared.streams.begin())->LeaveTopic();
}

}  // namespace caltwin
