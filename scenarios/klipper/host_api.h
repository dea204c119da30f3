#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace caltwin {

/// The host's API socket, never waited for: JSON objects, each ended by the byte 3.
class HostApi {
 public:
  explicit HostApi(std::filesystem::path path) : path_(std::move(path)) {}
  ~HostApi() { Close(); }
  HostApi(const HostApi&) = delete;
  HostApi& operator=(const HostApi&) = delete;

  /// Whether somebody listens there.
  bool Open();
  bool is_open() const { return socket_ >= 0; }
  /// Takes what has come; closed afterwards where the host has closed it.
  void Receive();
  /// Sends a request, and gives its number.
  int Ask(std::string_view method, const nlohmann::json& parameters);
  /// The answer to it, once, where it has come.
  std::optional<nlohmann::json> TakeAnswer(int number);
  /// What the host has printed since.
  std::vector<std::string> TakePrinted() { return std::exchange(printed_, {}); }

 private:
  void Close();
  void TakeObjects();

  std::filesystem::path path_;
  int socket_ = -1;
  int next_ = 1;
  std::string unread_{};
  std::map<int, nlohmann::json> answers_{};
  std::vector<std::string> printed_{};
};

}  // namespace caltwin
