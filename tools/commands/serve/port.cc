#include "tools/commands/serve/port.h"

#include <utility>

#include "sim/link/line_channel.h"
#include "tools/commands/serve/session.h"

namespace caltwin {
namespace {

constexpr std::size_t kLongestLine = 4096;  // What is longer is noise.

class LinkPort final : public Port {
 public:
  LinkPort(Link* link, Say say) : session_(link), say_(std::move(say)) {}

  bool Hear(std::string_view bytes) override {
    lines_.Add(bytes);
    std::string line;
    while (lines_.Take(&line)) {
      for (const std::string& answer : session_.Answer(line)) say_(answer + "\n");
    }
    return lines_.size() <= kLongestLine;
  }

 private:
  ServeSession session_;
  Say say_;
  LineSplitter lines_{};
};

}  // namespace

OpenPort PortsOf(Link* link) {
  return [link](Say say) {
    return std::make_unique<LinkPort>(link, std::move(say));
  };
}

}  // namespace caltwin
