#include "sim/controllers/klipper/objects.h"

#include <algorithm>

namespace caltwin {
namespace klipper {
namespace {

std::optional<Clock> Earlier(std::optional<Clock> a, std::optional<Clock> b) {
  if (a && b) return std::min(*a, *b);
  return a ? a : b;
}

struct NextEventVisitor {
  template <typename Still>
  std::optional<Clock> operator()(const Still&) const {
    return std::nullopt;
  }
  std::optional<Clock> operator()(const TriggerSync& sync) const {
    if (!sync.can_trigger) return std::nullopt;
    return Earlier(sync.report_at, sync.expires_at);
  }
  std::optional<Clock> operator()(const Endstop& endstop) const {
    if (!endstop.is_homing || !endstop.hit) return std::nullopt;
    return endstop.confirmed_at();
  }
  std::optional<Clock> operator()(const Output& output) const {
    return output.NextEvent();
  }
  std::optional<Clock> operator()(const AnalogIn& analog) const { return analog.next; }
  std::optional<Clock> operator()(const Buttons& buttons) const { return buttons.next; }
};

}  // namespace

std::optional<Clock> Output::NextEvent() const {
  const auto change = changes.empty() ? std::nullopt : std::optional(changes[0].at);
  return Earlier(change, deadline);
}

std::optional<Clock> NextEventOf(const Object& object) {
  return std::visit(NextEventVisitor{}, object);
}

}  // namespace klipper
}  // namespace caltwin
