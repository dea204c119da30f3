#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace caltwin {

/// What is told to whoever listens, as server-sent events (text/event-stream): each
/// with a number, so that a client that lost its connection asks for what it missed
/// (Last-Event-ID). Safe to use from several threads.
class EventTopic {
 public:
  using Listener = std::function<void(const std::string& text)>;

  /// @param most_kept, most_kept_bytes  so many past events, and so long in all, are
  ///   told to a newcomer who asks for them
  explicit EventTopic(std::size_t most_kept = 1000,
                      std::size_t most_kept_bytes = 500'000)
      : most_kept_(most_kept), most_kept_bytes_(most_kept_bytes) {}

  /// Tells everybody. `data`: one line of JSON.
  void Publish(const std::string& name, const std::string& data);
  /// Listens from now on; first, at once, to every event kept after number `since`.
  /// `listener` must not wait, nor listen or leave in turn. Returns what Leave takes.
  int Listen(std::uint64_t since, Listener listener);
  void Leave(int listener);
  std::size_t listeners() const;
  std::uint64_t last() const;

 private:
  struct Event {
    std::uint64_t number = 0;
    std::string text{};
  };

  mutable std::mutex mutex_{};
  std::size_t most_kept_, most_kept_bytes_;
  std::size_t kept_bytes_ = 0;
  std::uint64_t last_ = 0;
  int next_listener_ = 0;
  std::deque<Event> kept_{};
  std::map<int, Listener> listeners_{};
};

}  // namespace caltwin
