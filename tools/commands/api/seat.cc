#include "tools/commands/api/seat.h"

#include <fmt/format.h>

#include "sim/base/text_file.h"
#include "tools/server/problem.h"

namespace caltwin {

OperatorSeat::Held OperatorSeat::Take(const HttpRequest& request,
                                      const std::string& doing) {
  constexpr std::size_t kLongest = 60;
  std::string name = Printable(request.Header("x-operator"));
  if (name.size() > kLongest) {
    std::size_t end = kLongest;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) --end;
    name.resize(end);
  }
  if (name.empty()) name = "somebody";
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!sitter_) is_aborted_ = false;
  if (sitter_) {
    throw Problem(
        409,
        fmt::format("the machine is taken: {} is {}", sitter_->name, sitter_->doing),
        {{.detail = "one operator moves a machine at a time",
          .hint = "wait until it is done, or watch it at /api/events"}},
        {{"held_by", sitter_->name}, {"doing", sitter_->doing}});
  }
  sitter_ = Sitter{.name = name, .doing = doing};
  return Held(this);
}

std::optional<OperatorSeat::Sitter> OperatorSeat::sitter() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return sitter_;
}

bool OperatorSeat::Abort() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sitter_) is_aborted_ = true;
  return sitter_.has_value();
}

void OperatorSeat::IfFree(const std::function<void()>& look) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!sitter_) look();
}

void OperatorSeat::Rise() {
  const std::lock_guard<std::mutex> lock(mutex_);
  sitter_.reset();
}

}  // namespace caltwin
