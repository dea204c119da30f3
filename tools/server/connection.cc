#include "tools/server/connection.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http.hpp>
#include <fmt/format.h>

namespace caltwin {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::uint32_t kMostHeader_bytes = 16'384;
constexpr std::size_t kPiece_bytes = 4096;
constexpr std::size_t kBuffer_bytes = 65'536;
constexpr std::chrono::seconds kHeartbeat{15};  // Of an event stream that says nothing.
constexpr std::chrono::seconds kDrain{2};       // What a refused client still sends.

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

// Of whatever it answers.
void SetCommonFields(http::response<http::string_body>* message) {
  message->version(11);
  message->set(http::field::server, "caltwin");
  message->set("X-Content-Type-Options", "nosniff");
  message->set("Referrer-Policy", "no-referrer");
  message->set(http::field::cache_control, "no-store");
}

}  // namespace

ConnectionTable::ConnectionTable(const Routes& what,
                                 const Gate& who,
                                 const ServerLimits& most)
    : routes(what),
      gate(who),
      limits(most),
      bodies(most.bodies_bytes),
      workers(static_cast<std::size_t>(most.threads)) {}

bool ConnectionTable::HasRoom() {
  return open.size() < static_cast<std::size_t>(limits.connections) || MakeRoom();
}

bool ConnectionTable::MakeRoom() {
  Connection* longest = nullptr;
  for (Connection* const one : open) {
    if (!one->is_waiting()) continue;
    if (longest == nullptr || one->turn() < longest->turn()) longest = one;
  }
  if (longest != nullptr) longest->Close();
  return longest != nullptr;
}

Connection::Connection(tcp::socket socket, ConnectionTable* table)
    : stream_(std::move(socket)),
      table_(table),
      body_(&table->bodies),
      heartbeat_(table->io),
      buffer_(kBuffer_bytes) {
  table_->open.insert(this);
}

Connection::~Connection() {
  LeaveTopic();
  table_->open.erase(this);
}

void Connection::LeaveTopic() {
  if (!topic_) return;
  topic_->Leave(listener_);
  topic_.reset();
  --table_->streams;
}

void Connection::WaitFrom(Stage stage) {
  stage_ = stage;
  turn_ = ++table_->last_turn;
}

void Connection::ReadHeader() {
  parser_.emplace();
  parser_->header_limit(kMostHeader_bytes);
  parser_->body_limit(boost::none);
  WaitFrom(Stage::kWaiting);
  is_idle_ = is_idle_ && buffer_.size() == 0;
  // Counted from here, whatever trickles in.
  stream_.expires_after(is_idle_ ? table_->limits.idle : table_->limits.to_begin);
  if (buffer_.size() > 0) return ParseHeader();
  ReadMoreOfHeader();
}

void Connection::ReadMoreOfHeader() {
  stream_.async_read_some(
      buffer_.prepare(kPiece_bytes),
      [self = shared_from_this()](error_code error, std::size_t count) {
        if (error) return self->Close();
        self->buffer_.commit(count);
        if (std::exchange(self->is_idle_, false)) {
          self->stream_.expires_after(self->table_->limits.to_begin);
        }
        self->ParseHeader();
      });
}

void Connection::ParseHeader() {
  error_code error;
  buffer_.consume(parser_->put(buffer_.data(), error));
  if (error == http::error::need_more) return ReadMoreOfHeader();
  HeaderRead(error);
}

void Connection::HeaderRead(error_code error) {
  if (error == http::error::header_limit) {
    return Refuse(Problem(431, "the headers are longer than 16 kB"));
  }
  if (error) {
    return Refuse(Problem(400, "this is no HTTP request: " + error.message()));
  }
  bool is_sound = false;
  request_ = ReadRequest(parser_->get(), &is_sound);
  if (!is_sound) return Refuse(Problem(400, "the target is no path of this server"));
  try {
    if (!table_->gate.IsEntrance(request_)) table_->gate.Check(request_);
    route_ = RouteOf(&request_);
  } catch (const Problem& problem) {
    return Refuse(problem);
  }
  if (const auto length = parser_->content_length()) {
    if (*length > route_.most_bytes) return RefuseLength();
    if (!body_.GrowTo(*length)) return RefuseBusy("other uploads fill the memory");
  }
  parser_->body_limit(route_.most_bytes);
  if (SmallLetters(request_.Header("expect")) == "100-continue") return Continue();
  stream_.expires_after(table_->limits.to_send);
  ReadBody();
}

Route Connection::RouteOf(HttpRequest* request) const {
  if (table_->gate.IsEntrance(*request)) {
    return {.handler = [this](const HttpRequest&) {
      return table_->gate.Enter();
    }};
  }
  if (request->method == "OPTIONS") {
    const std::string allowed = table_->routes.Allowed(request->path);
    return {.handler = [allowed](const HttpRequest&) {
      return HttpResponse{.status = 204, .headers = {{"Allow", allowed}}};
    }};
  }
  return table_->routes.Find(request);
}

void Connection::Continue() {
  static constexpr std::string_view kGoOn = "HTTP/1.1 100 Continue\r\n\r\n";
  stream_.expires_after(table_->limits.to_send);
  asio::async_write(stream_,
                    asio::buffer(kGoOn),
                    [self = shared_from_this()](error_code error, auto) {
                      error ? self->Close() : self->ReadBody();
                    });
}

// Piece by piece: of a body in chunks only what has come is known.
void Connection::ReadBody() {
  if (parser_->is_done()) return BodyRead({});
  http::async_read_some(
      stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, auto) {
        self->BodyRead(error);
      });
}

void Connection::BodyRead(error_code error) {
  if (error == http::error::body_limit) return RefuseLength();
  if (error) return Close();
  if (!body_.GrowTo(parser_->get().body().size())) {
    return RefuseBusy("other uploads fill the memory");
  }
  if (!parser_->is_done()) return ReadBody();
  request_.body = std::move(parser_->get().body());
  Handle();
}

void Connection::Handle() {
  keeps_ = parser_->get().keep_alive();
  if (route_.pace == Route::Pace::kQuick) return Send(AnswerOf(route_, request_));
  if (table_->waiting >= table_->limits.waiting) {
    HttpResponse busy = Problem(503, "the server is busy: try again").Response();
    busy.headers.emplace_back("Retry-After", "2");
    return Send(busy);
  }
  ++table_->waiting;
  WaitFrom(Stage::kAtWork);
  stream_.expires_never();
  asio::post(table_->workers, [self = shared_from_this()]() mutable {
    auto answer =
        std::make_shared<HttpResponse>(AnswerOf(self->route_, self->request_));
    ConnectionTable* const table = self->table_;
    // The connection goes along: it ends on the thread of `io` alone.
    asio::post(table->io, [self = std::move(self), answer] {
      --self->table_->waiting;
      self->Send(*answer);
    });
  });
}

// Answers and closes: what follows on the wire may be the rest of a body.
void Connection::Refuse(const Problem& problem) {
  keeps_ = false;
  is_refused_ = true;
  HttpResponse response = problem.Response();
  if (problem.status() == 405) {
    response.headers.emplace_back("Allow", table_->routes.Allowed(request_.path));
  }
  if (problem.status() == 401)
    response.headers.emplace_back("WWW-Authenticate", "Bearer");
  if (problem.status() == 503) response.headers.emplace_back("Retry-After", "2");
  Send(response);
}

void Connection::RefuseLength() {
  Refuse(
      Problem(413, fmt::format("a body here is at most {} bytes", route_.most_bytes)));
}

void Connection::RefuseBusy(const std::string& why) {
  Refuse(Problem(503, "the server is busy: " + why + ": try again"));
}

void Connection::ReleaseBody() {
  request_.body = std::string();
  if (parser_) parser_->get().body() = std::string();
  body_.Release();
}

void Connection::Send(const HttpResponse& response) {
  ReleaseBody();
  if (response.events) return Stream(response.events);
  auto message = std::make_shared<http::response<http::string_body>>();
  SetCommonFields(message.get());
  message->result(static_cast<unsigned>(response.status));
  message->reason(std::string(ReasonOf(response.status)));
  for (const auto& [name, value] : response.headers) message->set(name, value);
  const bool has_body = response.status != 204 && response.status != 304;
  if (has_body) message->set(http::field::content_type, response.content_type);
  message->keep_alive(keeps_);
  message->body() = has_body ? response.body : "";
  if (has_body) message->prepare_payload();
  if (request_.method == "HEAD") message->body().clear();
  WaitFrom(Stage::kWaiting);
  stream_.expires_after(table_->limits.to_send);
  http::async_write(
      stream_, *message, [self = shared_from_this(), message](error_code error, auto) {
        self->Written(error);
      });
}

void Connection::Written(error_code error) {
  if (error) return Close();
  if (is_refused_) {
    std::ignore = stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    stream_.expires_after(kDrain);
    return Drain();
  }
  if (!keeps_) return Close();
  request_ = {};
  is_idle_ = true;
  ReadHeader();
}

// A socket that closes on unread bytes takes the answer back that is on its way: what
// the client still sends is thrown away for a moment.
void Connection::Drain() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(kBuffer_bytes),
                          [self = shared_from_this()](error_code error, auto) {
                            error ? self->Close() : self->Drain();
                          });
}

void Connection::Stream(const std::shared_ptr<EventTopic>& topic) {
  if (table_->streams >= table_->limits.streams) {
    return RefuseBusy("too many listen already");
  }
  unsent_.push_back(
      "HTTP/1.1 200 OK\r\nServer: caltwin\r\nContent-Type: text/event-stream\r\n"
      "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
      "Connection: close\r\n\r\nretry: 2000\n\n");
  if (request_.method == "HEAD") return WriteUnsent();
  WaitFrom(Stage::kStreaming);
  stream_.expires_never();
  topic_ = topic;
  ++table_->streams;
  std::uint64_t since = topic->last();
  const std::string last = request_.Header("last-event-id");
  const auto asked = request_.query.find("since");
  const std::string& from =
      last.empty() && asked != request_.query.end() ? asked->second : last;
  if (!from.empty()) since = std::strtoull(from.c_str(), nullptr, 10);
  const std::weak_ptr<Connection> weak = weak_from_this();
  listener_ = topic->Listen(since, [weak, table = table_](const std::string& text) {
    asio::post(table->io, [weak, text] {
      if (const auto self = weak.lock()) self->Push(text);
    });
  });
  WriteUnsent();
  Beat();
  NoticeEnd();
}

void Connection::Push(const std::string& text) {
  if (!stream_.socket().is_open()) return;
  unsent_bytes_ += text.size();
  if (unsent_bytes_ > table_->limits.unsent_bytes) return Close();
  unsent_.push_back(text);
  if (unsent_.size() == 1) WriteUnsent();
}

void Connection::WriteUnsent() {
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

void Connection::Beat() {
  heartbeat_.expires_after(kHeartbeat);
  heartbeat_.async_wait([weak = weak_from_this()](error_code error) {
    const auto self = weak.lock();
    if (error || !self || !self->stream_.socket().is_open()) return;
    self->Push(":\n\n");
    self->Beat();
  });
}

// A listener says nothing more: what is read is its end.
void Connection::NoticeEnd() {
  stream_.async_read_some(buffer_.prepare(kPiece_bytes),
                          [self = shared_from_this()](error_code error, auto) {
                            error ? self->Close() : self->NoticeEnd();
                          });
}

void Connection::Close() {
  LeaveTopic();
  table_->open.erase(this);
  heartbeat_.cancel();
  error_code ignored;
  std::ignore = stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
  std::ignore = stream_.socket().close(ignored);
}

}  // namespace caltwin
