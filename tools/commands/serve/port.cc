#include "tools/commands/serve/port.h"

#include <chrono>
#include <future>
#include <utility>
#include <vector>

#include "sim/link/line_channel.h"
#include "tools/commands/serve/session.h"

namespace caltwin {
namespace {

constexpr std::size_t kLongestLine = 4096;  // What is longer is noise.
constexpr std::chrono::seconds kBusy{2};

class LinkPort final : public Port {
 public:
  LinkPort(Link* link, bool says_busy, Say say)
      : session_(link), says_busy_(says_busy), say_(std::move(say)) {}

  bool Hear(std::string_view bytes) override {
    lines_.Add(bytes);
    std::string line;
    while (lines_.Take(&line)) {
      for (const std::string& answer : Answer(line)) say_(answer + "\n");
    }
    return lines_.size() <= kLongestLine;
  }

 private:
  std::vector<std::string> Answer(const std::string& line) {
    if (!says_busy_) return session_.Answer(line);
    auto answer = std::async(std::launch::async, [&] { return session_.Answer(line); });
    while (answer.wait_for(kBusy) == std::future_status::timeout) {
      say_("echo:busy: processing\n");
    }
    return answer.get();
  }

  ServeSession session_;
  bool says_busy_;
  Say say_;
  LineSplitter lines_{};
};

}  // namespace

OpenPort PortsOf(Link* link, bool says_busy) {
  return [link, says_busy](Say say) {
    return std::make_unique<LinkPort>(link, says_busy, std::move(say));
  };
}

}  // namespace caltwin
