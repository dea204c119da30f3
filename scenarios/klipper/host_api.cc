#include "scenarios/klipper/host_api.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace caltwin {
namespace {

constexpr char kEnd = '\x03';
constexpr std::size_t kMostUnread = std::size_t{16} << 20;

}  // namespace

void HostApi::Close() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  unread_.clear();
}

bool HostApi::Open() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = path_.string();
  if (path.size() >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const auto* const where = reinterpret_cast<const sockaddr*>(&address);
  if (socket_ >= 0 && connect(socket_, where, sizeof address) == 0) return true;
  Close();
  return false;
}

void HostApi::Receive() {
  std::array<char, 65536> bytes{};
  while (is_open()) {
    const ssize_t num = recv(socket_, bytes.data(), bytes.size(), 0);
    if (num < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (num <= 0 || unread_.size() > kMostUnread) {
      TakeObjects();
      return Close();
    }
    unread_.append(bytes.data(), static_cast<std::size_t>(num));
  }
  TakeObjects();
}

void HostApi::TakeObjects() {
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = unread_.find(kEnd, begin)) != std::string::npos;
       begin = end + 1) {
    const auto first = unread_.begin();
    nlohmann::json one =
        nlohmann::json::parse(first + static_cast<std::ptrdiff_t>(begin),
                              first + static_cast<std::ptrdiff_t>(end),
                              nullptr,
                              false);
    if (!one.is_object()) continue;
    const auto id = one.find("id");
    const auto parameters = one.find("params");
    if (id != one.end() && id->is_number_integer()) {
      const int number = id->get<int>();
      answers_[number] = std::move(one);
    } else if (parameters != one.end() && parameters->is_object() &&
               parameters->contains("response")) {
      const nlohmann::json& text = (*parameters)["response"];
      if (text.is_string()) printed_.push_back(text.get<std::string>());
    }
  }
  unread_.erase(0, begin);
}

int HostApi::Ask(std::string_view method, const nlohmann::json& parameters) {
  const int number = next_++;
  const nlohmann::json request = {
      {"id", number}, {"method", method}, {"params", parameters}};
  const std::string text =
      request.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + kEnd;
  const ssize_t num = send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  if (num != static_cast<ssize_t>(text.size())) Close();
  return number;
}

std::optional<nlohmann::json> HostApi::TakeAnswer(int number) {
  const auto found = answers_.find(number);
  if (found == answers_.end()) return std::nullopt;
  nlohmann::json answer = std::move(found->second);
  answers_.erase(found);
  return answer;
}

}  // namespace caltwin
