#include "tools/server/events.h"

#include <utility>

#include <fmt/format.h>

namespace caltwin {

void EventTopic::Publish(const std::string& name, const std::string& data) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++last_;
  kept_.push_back(
      {last_, fmt::format("id: {}\nevent: {}\ndata: {}\n\n", last_, name, data)});
  kept_bytes_ += kept_.back().text.size();
  for (const auto& [id, listener] : listeners_) listener(kept_.back().text);
  while (kept_.size() > most_kept_ || kept_bytes_ > most_kept_bytes_) {
    kept_bytes_ -= kept_.front().text.size();
    kept_.pop_front();
  }
}

int EventTopic::Listen(std::uint64_t since, Listener listener) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const Event& event : kept_) {
    if (event.number > since) listener(event.text);
  }
  listeners_.emplace(++next_listener_, std::move(listener));
  return next_listener_;
}

void EventTopic::Leave(int listener) {
  const std::lock_guard<std::mutex> lock(mutex_);
  listeners_.erase(listener);
}

std::size_t EventTopic::listeners() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return listeners_.size();
}

std::uint64_t EventTopic::last() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return last_;
}

}  // namespace caltwin
