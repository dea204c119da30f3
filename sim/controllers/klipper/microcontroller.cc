#include "sim/controllers/klipper/microcontroller.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/require.h"

namespace caltwin {
namespace klipper {
namespace {

constexpr Clock kLook = kTicksPerSecond / 500;      // Between two looks at a pin.
constexpr Clock kStatsEvery = 5 * kTicksPerSecond;  // Told of by itself.
constexpr std::string_view kParserError = "Command parser error";

}  // namespace

Microcontroller::Microcontroller(Board* board)
    : board_(board),
      dictionary_(CompressedDictionary(*board)),
      origin_(static_cast<std::size_t>(board->num_motors()), 0) {}

// ---- The wire

void Microcontroller::Say(std::string_view response,
                          const std::vector<Argument>& arguments) {
  const Bytes block = BlockOf(sequence_, EncodeResponse(response, arguments));
  output_.insert(output_.end(), block.begin(), block.end());
}

Bytes Microcontroller::TakeOutput() {
  return std::exchange(output_, {});
}

void Microcontroller::Receive(ByteView bytes) {
  reader_.Feed(bytes);
  while (const auto received = reader_.Take()) {
    const bool is_expected =
        received->is_sound && received->sequence == sequence_ % kSequences;
    if (is_expected) {
      ++sequence_;
      ObeyAll(received->payload);
    }
    // Acknowledges, or asks again for what is expected.
    const Bytes answer = BlockOf(sequence_, {});
    output_.insert(output_.end(), answer.begin(), answer.end());
  }
}

void Microcontroller::ObeyAll(ByteView payload) {
  while (!payload.empty()) {
    const auto message = TakeCommand(&payload);
    if (!message) return ShutDown(kParserError);
    Obey(*message);
  }
}

void Microcontroller::Obey(const Message& message) {
  const auto& all = Obeyed();
  const auto found = std::ranges::find(all, message.format->name, &Command::name);
  Require(found != all.end(), "every command of the dictionary is obeyed");
  if (shutdown_ && !found->in_shutdown) {
    return Say("is_shutdown", {static_cast<std::int64_t>(*shutdown_)});
  }
  (this->*found->obey)(message);
}

void Microcontroller::ShutDown(std::string_view why) {
  if (shutdown_) return;
  const auto words = ShutdownWords();
  const auto found = std::ranges::find(words, why);
  Require(found != words.end(), "the words of a shutdown are in the dictionary");
  shutdown_ = static_cast<std::size_t>(found - words.begin());
  for (Object& object : objects_) {
    if (auto* stepper = std::get_if<Stepper>(&object)) stepper->queue.Stop(now_);
    if (auto* sync = std::get_if<TriggerSync>(&object)) sync->can_trigger = false;
    if (auto* endstop = std::get_if<Endstop>(&object)) endstop->is_homing = false;
    if (auto* analog = std::get_if<AnalogIn>(&object)) analog->next.reset();
    if (auto* buttons = std::get_if<Buttons>(&object)) buttons->next.reset();
    if (auto* output = std::get_if<Output>(&object)) {
      output->changes.clear();
      output->deadline.reset();
      output->value = output->default_value;
    }
  }
  Say("shutdown", {now_, static_cast<std::int64_t>(*shutdown_)});
}

std::optional<std::string_view> Microcontroller::shutdown() const {
  if (!shutdown_) return std::nullopt;
  return ShutdownWords()[*shutdown_];
}

// ---- Time

Motors Microcontroller::MotorsAt(Clock clock) const {
  Motors steps(static_cast<Eigen::Index>(origin_.size()));
  for (std::size_t i = 0; i < origin_.size(); ++i) {
    steps[static_cast<Eigen::Index>(i)] = static_cast<double>(origin_[i]);
  }
  for (const Object& object : objects_) {
    const auto* stepper = std::get_if<Stepper>(&object);
    if (stepper == nullptr) continue;
    steps[stepper->motor_index] += static_cast<double>(stepper->queue.At(clock));
  }
  return steps;
}

bool Microcontroller::IsWatching() const {
  return std::ranges::any_of(objects_, [](const Object& object) {
    const auto* endstop = std::get_if<Endstop>(&object);
    return endstop != nullptr && endstop->is_homing;
  });
}

std::optional<Clock> Microcontroller::NextOfObjects() const {
  std::optional<Clock> next;
  if (crc_) next = stats_at_;
  for (const Object& object : objects_) {
    const auto one = NextEventOf(object);
    if (one && (!next || *one < *next)) next = one;
  }
  return next;
}

std::optional<Clock> Microcontroller::NextEvent() const {
  const auto next = NextOfObjects();
  if (!IsWatching()) return next;
  return std::min(next.value_or(now_ + kLook), now_ + kLook);
}

Clock Microcontroller::Horizon(Clock to) const {
  const Clock looked = IsWatching() ? std::min(to, now_ + kLook) : to;
  const auto next = NextOfObjects();
  return next ? std::clamp(*next, now_, looked) : looked;
}

void Microcontroller::Advance(Clock to) {
  while (now_ < to) {
    const Clock horizon = Horizon(to);
    WatchEndstops(horizon);
    // An endstop that was hit just now may be confirmed before.
    GoTo(Horizon(horizon));
    FireDue();
  }
}

void Microcontroller::Follow(Clock clock) {
  std::vector<Clock> stops;
  for (const Object& object : objects_) {
    const auto* stepper = std::get_if<Stepper>(&object);
    if (stepper != nullptr) stepper->queue.AppendTurns(now_, clock, &stops);
  }
  std::ranges::sort(stops);
  stops.push_back(clock);
  for (const Clock stop : stops) board_->Follow(MotorsAt(stop));
}

void Microcontroller::GoTo(Clock clock) {
  Follow(clock);
  now_ = clock;
  for (Object& object : objects_) {
    if (auto* stepper = std::get_if<Stepper>(&object)) stepper->queue.Forget(now_);
    auto* endstop = std::get_if<Endstop>(&object);
    if (endstop == nullptr || !endstop->is_homing || endstop->hit) continue;
    const Clock behind = now_ - endstop->next;
    if (behind >= 0) {
      endstop->next += (behind / endstop->rest_ticks + 1) * endstop->rest_ticks;
    }
  }
}

bool Microcontroller::ReadsAsAwaited(const Endstop& endstop, Clock clock) {
  return board_->IsHigh(endstop.pin, MotorsAt(clock)) == endstop.awaited;
}

std::optional<Clock> Microcontroller::FirstHit(const Endstop& endstop, Clock horizon) {
  const auto clock_of = [&](std::int64_t sample) {
    return endstop.next + sample * endstop.rest_ticks;
  };
  if (horizon < endstop.next) return std::nullopt;
  std::int64_t hit = (horizon - endstop.next) / endstop.rest_ticks, before = -1;
  if (!ReadsAsAwaited(endstop, clock_of(hit))) return std::nullopt;
  while (hit - before > 1) {
    const std::int64_t middle = (hit + before) / 2;
    (ReadsAsAwaited(endstop, clock_of(middle)) ? hit : before) = middle;
  }
  return clock_of(hit);
}

void Microcontroller::Watch(Endstop* endstop, Clock horizon) {
  while (const auto hit = FirstHit(*endstop, horizon)) {
    std::int64_t alike = 1;
    while (alike < endstop->samples &&
           ReadsAsAwaited(*endstop, *hit + alike * endstop->sample_ticks)) {
      ++alike;
    }
    if (alike == endstop->samples) {
      endstop->hit = hit;
      return;
    }
    endstop->next = *hit + alike * endstop->sample_ticks + endstop->rest_ticks;
  }
}

void Microcontroller::WatchEndstops(Clock horizon) {
  for (Object& object : objects_) {
    auto* endstop = std::get_if<Endstop>(&object);
    if (endstop == nullptr || !endstop->is_homing || endstop->hit) continue;
    Watch(endstop, horizon);
  }
}

void Microcontroller::FireDue() {
  for (std::size_t oid = 0; oid < objects_.size(); ++oid) {
    Object& object = objects_[oid];
    const auto next = NextEventOf(object);
    if (!next || *next > now_) continue;
    std::visit([&](auto& one) { Fire(static_cast<int>(oid), &one); }, object);
  }
  if (crc_ && stats_at_ <= now_) {
    stats_at_ += kStatsEvery;
    Say("stats", {5000, 1'000'000, 100'000});
  }
}

void Microcontroller::Trigger(TriggerSync* sync, std::int64_t reason) {
  if (!sync->can_trigger) return;
  sync->can_trigger = false;
  sync->reason = reason;
  sync->report_at.reset();
  sync->expires_at.reset();
  for (const int oid : std::exchange(sync->steppers, {})) {
    Stepper& stepper = std::get<Stepper>(objects_[static_cast<std::size_t>(oid)]);
    stepper.queue.Stop(now_);
    stepper.is_frozen = true;
    stepper.sense = -1;
  }
  // What was seen of the time to come was of motors that would have gone on.
  for (Object& object : objects_) {
    auto* endstop = std::get_if<Endstop>(&object);
    if (endstop != nullptr && endstop->hit && *endstop->hit > now_) {
      endstop->hit.reset();
    }
  }
}

void Microcontroller::Report(int oid, const TriggerSync& sync, Clock clock) {
  Say("trsync_state", {oid, sync.can_trigger ? 1 : 0, sync.reason, clock});
}

void Microcontroller::Fire(int oid, TriggerSync* sync) {
  if (sync->expires_at && *sync->expires_at <= now_) {
    Trigger(sync, sync->expire_reason);
    return Report(oid, *sync, 0);
  }
  Report(oid, *sync, *sync->report_at);
  *sync->report_at += sync->report_ticks;
}

void Microcontroller::Fire(int /*oid*/, Endstop* endstop) {
  endstop->is_homing = false;
  endstop->next = *endstop->hit + endstop->rest_ticks;
  endstop->hit.reset();
  auto& sync = std::get<TriggerSync>(objects_[static_cast<std::size_t>(endstop->sync)]);
  if (!sync.can_trigger) return;
  Trigger(&sync, endstop->reason);
  Report(endstop->sync, sync, 0);
}

void Microcontroller::Fire(int /*oid*/, Output* output) {
  if (!output->changes.empty() && output->changes[0].at <= now_) {
    const Output::Change change = output->changes[0];
    output->changes.pop_front();
    output->value = change.value;
    output->deadline.reset();
    if (output->longest > 0 && output->value != output->default_value) {
      output->deadline = change.at + output->longest;
    }
    return;
  }
  output->deadline.reset();
  ShutDown(output->is_pwm ? "Missed scheduling of next hard pwm event"
                          : "Missed scheduling of next digital out event");
}

void Microcontroller::Fire(int oid, AnalogIn* analog) {
  const double one = std::clamp(board_->Analog(analog->pin), 0.0, 1.0) * kAdcMax;
  const std::int64_t value = std::llround(one) * analog->samples;
  *analog->next += analog->rest_ticks;
  Say("analog_in_state", {oid, *analog->next, value});
  const bool is_outside = value < analog->least || value > analog->most;
  analog->outside = is_outside ? analog->outside + 1 : 0;
  if (analog->allowed_outside > 0 && analog->outside >= analog->allowed_outside) {
    ShutDown("ADC out of range");
  }
}

void Microcontroller::SendButtons(int oid, Buttons* buttons) {
  if (buttons->states.empty()) return;
  Say("buttons_state", {oid, buttons->acknowledged, Bytes(buttons->states)});
  buttons->polls_to_send = buttons->retransmit;
}

void Microcontroller::Fire(int oid, Buttons* buttons) {
  constexpr std::size_t kMostStates = 8;
  *buttons->next += buttons->rest_ticks;
  const Motors steps = MotorsAt(now_);
  unsigned state = buttons->invert;
  for (std::size_t i = 0; i < buttons->pins.size(); ++i) {
    if (board_->IsHigh(buttons->pins[i], steps)) state ^= 1U << i;
  }
  const auto now = static_cast<std::uint8_t>(state);
  if (now != buttons->last && buttons->states.size() < kMostStates) {
    buttons->last = now;
    buttons->states.push_back(now);
    return SendButtons(oid, buttons);
  }
  if (--buttons->polls_to_send <= 0) SendButtons(oid, buttons);
}

}  // namespace klipper
}  // namespace caltwin
