#include <algorithm>
#include <utility>

#include "sim/controllers/klipper/microcontroller.h"

namespace caltwin {
namespace klipper {
const std::vector<Microcontroller::Command>& Microcontroller::Obeyed() {
  using M = Microcontroller;
  static const std::vector<Command> all = {
      {"identify", &M::Identify, true},
      {"get_uptime", &M::GetUptime, true},
      {"get_clock", &M::GetClock, true},
      {"get_config", &M::GetConfig, true},
      {"emergency_stop", &M::EmergencyStop, true},
      {"clear_shutdown", &M::ClearShutdown, true},
      {"config_reset", &M::ConfigReset, true},
      {"allocate_oids", &M::AllocateOids},
      {"finalize_config", &M::FinalizeConfig},
      {"config_stepper", &M::ConfigStepper},
      {"queue_step", &M::QueueStep},
      {"set_next_step_dir", &M::SetNextStepDir},
      {"reset_step_clock", &M::ResetStepClock},
      {"stepper_get_position", &M::StepperGetPosition},
      {"stepper_stop_on_trigger", &M::StepperStopOnTrigger},
      {"config_trsync", &M::ConfigTrsync},
      {"trsync_start", &M::TrsyncStart},
      {"trsync_set_timeout", &M::TrsyncSetTimeout},
      {"trsync_trigger", &M::TrsyncTrigger},
      {"config_endstop", &M::ConfigEndstop},
      {"endstop_home", &M::EndstopHome},
      {"endstop_query_state", &M::EndstopQueryState},
      {"config_digital_out", &M::ConfigDigitalOut},
      {"set_digital_out_pwm_cycle", &M::SetDigitalOutPwmCycle},
      {"queue_digital_out", &M::QueueDigitalOut},
      {"update_digital_out", &M::UpdateDigitalOut},
      {"set_digital_out", &M::SetDigitalOut},
      {"config_pwm_out", &M::ConfigPwmOut},
      {"queue_pwm_out", &M::QueuePwmOut},
      {"config_analog_in", &M::ConfigAnalogIn},
      {"query_analog_in", &M::QueryAnalogIn},
      {"config_buttons", &M::ConfigButtons},
      {"buttons_add", &M::ButtonsAdd},
      {"buttons_query", &M::ButtonsQuery},
      {"buttons_ack", &M::ButtonsAck},
  };
  return all;
}

// ---- Objects

void Microcontroller::Add(const Message& message, Object object) {
  const auto oid = static_cast<std::size_t>(message["oid"]);
  const bool is_free = !crc_ && oid < objects_.size() &&
                       std::holds_alternative<std::monostate>(objects_[oid]);
  if (!is_free) return ShutDown("Can't assign oid");
  objects_[oid] = std::move(object);
}

std::optional<int> Microcontroller::PinOf(const Message& message,
                                          std::string_view name) {
  const std::int64_t pin = message[name];
  if (pin < static_cast<std::int64_t>(board_->pins().size())) {
    return static_cast<int>(pin);
  }
  ShutDown("Not a valid input pin");
  return std::nullopt;
}

std::optional<Clock> Microcontroller::TimeOf(const Message& message) {
  const Clock clock = Extended(message["clock"], now_);
  if (clock >= now_) return clock;
  ShutDown("Timer too close");
  return std::nullopt;
}

std::size_t Microcontroller::NumMovesWaiting() const {
  std::size_t num = 0;
  for (const Object& object : objects_) {
    if (const auto* one = std::get_if<Stepper>(&object))
      num += one->queue.num_waiting();
    if (const auto* one = std::get_if<Output>(&object)) num += one->changes.size();
  }
  return num;
}

// ---- The chip

void Microcontroller::Identify(const Message& message) {
  constexpr std::int64_t kMostChunk = 48;  // Number and offset fit into the block too.
  const auto size = static_cast<std::int64_t>(dictionary_.size());
  const std::int64_t from = std::min(message["offset"], size);
  const std::int64_t count = std::min({message["count"], size - from, kMostChunk});
  const auto begin = dictionary_.begin() + from;
  Say("identify_response", {message["offset"], Bytes(begin, begin + count)});
}

void Microcontroller::GetUptime(const Message&) {
  Say("uptime", {now_ >> 32, now_});
}

void Microcontroller::GetClock(const Message&) {
  Say("clock", {now_});
}

void Microcontroller::GetConfig(const Message&) {
  Say("config", {crc_ ? 1 : 0, crc_.value_or(0), shutdown_ ? 1 : 0, kMoveCount});
}

void Microcontroller::AllocateOids(const Message& message) {
  if (!objects_.empty()) return ShutDown("Can't assign oid");
  objects_.resize(static_cast<std::size_t>(message["count"]));
}

void Microcontroller::FinalizeConfig(const Message& message) {
  if (crc_) return ShutDown("Already finalized");
  crc_ = message["crc"];
  stats_at_ = now_ + 5 * kTicksPerSecond;
}

void Microcontroller::EmergencyStop(const Message&) {
  ShutDown("Command request");
}

void Microcontroller::ClearShutdown(const Message&) {
  shutdown_.reset();
}

void Microcontroller::ConfigReset(const Message&) {
  if (!shutdown_) return ShutDown("config_reset only available when shutdown");
  for (const Object& object : objects_) {
    const auto* stepper = std::get_if<Stepper>(&object);
    if (stepper == nullptr) continue;
    origin_[static_cast<std::size_t>(stepper->motor_index)] += stepper->queue.At(now_);
  }
  objects_.clear();
  crc_.reset();
  shutdown_.reset();
}

// ---- Steppers

void Microcontroller::ConfigStepper(const Message& message) {
  const auto pin = PinOf(message, "step_pin");
  if (!pin) return;
  const auto is_of = [&](int motor) {
    return std::ranges::any_of(objects_, [&](const Object& object) {
      const auto* other = std::get_if<Stepper>(&object);
      return other != nullptr && other->motor_index == motor;
    });
  };
  const auto motor = board_->MotorAt(*pin);
  if (!motor || is_of(*motor)) return ShutDown("Can't assign oid");
  Add(message, Stepper{.motor_index = *motor});
}

void Microcontroller::QueueStep(const Message& message) {
  auto* const stepper = Find<Stepper>(message);
  if (stepper == nullptr || stepper->is_frozen) return;
  if (message["count"] == 0) return ShutDown("Invalid count parameter");
  if (NumMovesWaiting() >= kMoveCount) return ShutDown("Move queue overflow");
  switch (stepper->queue.Append(
      message["interval"], message["count"], message["add"], stepper->sense, now_)) {
    case StepQueue::Fault::kNone:
      return;
    case StepQueue::Fault::kTooClose:
      return ShutDown("Timer too close");
    case StepQueue::Fault::kTooFarInPast:
      return ShutDown("Stepper too far in past");
  }
}

void Microcontroller::SetNextStepDir(const Message& message) {
  auto* const stepper = Find<Stepper>(message);
  if (stepper == nullptr || stepper->is_frozen) return;
  stepper->sense = message["dir"] != 0 ? 1 : -1;
}

void Microcontroller::ResetStepClock(const Message& message) {
  auto* const stepper = Find<Stepper>(message);
  if (stepper == nullptr) return;
  if (stepper->queue.IsActive(now_)) {
    return ShutDown("Can't reset time when stepper active");
  }
  stepper->is_frozen = false;
  stepper->queue.Reset(message["clock"]);
}

void Microcontroller::StepperGetPosition(const Message& message) {
  const auto* const stepper = Find<Stepper>(message);
  if (stepper == nullptr) return;
  Say("stepper_position", {message["oid"], stepper->queue.At(now_)});
}

void Microcontroller::StepperStopOnTrigger(const Message& message) {
  if (Find<Stepper>(message) == nullptr) return;
  auto* const sync = Find<TriggerSync>(message, "trsync_oid");
  if (sync == nullptr) return;
  const int oid = static_cast<int>(message["oid"]);
  if (std::ranges::find(sync->steppers, oid) == sync->steppers.end()) {
    sync->steppers.push_back(oid);
  }
}

// ---- Triggers

void Microcontroller::ConfigTrsync(const Message& message) {
  Add(message, TriggerSync{});
}

void Microcontroller::TrsyncStart(const Message& message) {
  auto* const sync = Find<TriggerSync>(message);
  if (sync == nullptr) return;
  *sync = {.can_trigger = true, .expire_reason = message["expire_reason"]};
  if (message["report_ticks"] == 0) return;
  sync->report_ticks = std::max(message["report_ticks"], kFastest);
  const Clock report_at = Extended(message["report_clock"], now_);
  if (report_at < now_) return ShutDown("Timer too close");
  sync->report_at = report_at;
}

void Microcontroller::TrsyncSetTimeout(const Message& message) {
  auto* const sync = Find<TriggerSync>(message);
  if (sync == nullptr || !sync->can_trigger) return;
  if (const auto clock = TimeOf(message)) sync->expires_at = clock;
}

void Microcontroller::TrsyncTrigger(const Message& message) {
  auto* const sync = Find<TriggerSync>(message);
  if (sync == nullptr) return;
  Trigger(sync, message["reason"]);
  Report(static_cast<int>(message["oid"]), *sync, 0);
}

void Microcontroller::ConfigEndstop(const Message& message) {
  if (const auto pin = PinOf(message, "pin")) Add(message, Endstop{.pin = *pin});
}

void Microcontroller::EndstopHome(const Message& message) {
  auto* const endstop = Find<Endstop>(message);
  if (endstop == nullptr) return;
  endstop->is_homing = false;
  endstop->hit.reset();
  if (message["sample_count"] == 0) return;
  if (Find<TriggerSync>(message, "trsync_oid") == nullptr) return;
  const auto clock = TimeOf(message);
  if (!clock) return;
  endstop->is_homing = true;
  endstop->next = *clock;
  endstop->sample_ticks = message["sample_ticks"];
  endstop->samples = message["sample_count"];
  endstop->rest_ticks = std::max(message["rest_ticks"], std::int64_t{1});
  endstop->awaited = message["pin_value"] != 0;
  endstop->sync = static_cast<int>(message["trsync_oid"]);
  endstop->reason = message["trigger_reason"];
  board_->Arm(endstop->pin);
}

void Microcontroller::EndstopQueryState(const Message& message) {
  const auto* const endstop = Find<Endstop>(message);
  if (endstop == nullptr) return;
  Say("endstop_state",
      {message["oid"],
       endstop->is_homing ? 1 : 0,
       endstop->next,
       board_->IsHigh(endstop->pin, MotorsAt(now_)) ? 1 : 0});
}

}  // namespace klipper
}  // namespace caltwin
