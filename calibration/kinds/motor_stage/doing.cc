#include "calibration/kinds/motor_stage/doing.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace caltwin {

void MotorDoing::Log(std::size_t axis, const std::string& text) {
  Say({"logged: " + text, Message::Kind::kLog});
  logged_ = {axis, text};
  const auto logged = axes_->Log(axis, text);
  if (!logged) Say("the controller did not log that: " + logged.error().reply);
}

void MotorDoing::Alert(std::size_t axis, const std::string& text) {
  ++done_.found.alerts;
  const bool is_logged = logged_.first == axis && text.starts_with(logged_.second);
  if (!is_logged) Log(axis, text);
  Say({"ALERT: operator wanted: " + text, Message::Kind::kCause});
  done_.result.ending = Ending::kRefused;
}

void MotorDoing::SafeOff(std::size_t axis) {
  ++done_.found.safe_modes;
  Did(axes_->Enable(axis, false));
  Say(fmt::format("safe mode: {} is switched off", MotorAxisName(axis)));
}

void MotorDoing::SafeSlow(std::size_t axis) {
  ++done_.found.safe_modes;
  const auto in_force_unit_s = TopSpeed_unit_s(axis);
  if (!in_force_unit_s) return;
  const double most_unit_s =
      std::min(*in_force_unit_s, axes_->drawing(axis).max_velocity_unit_s / 10);
  const bool is_kept = Did(axes_->SetField(203, axis, most_unit_s)) && Store(axis);
  if (!is_kept) return;
  Say(fmt::format("safe mode: {} moves at no more than {:g} {}/s (M203, stored)",
                  MotorAxisName(axis),
                  most_unit_s,
                  axes_->drawing(axis).unit()));
}

bool MotorDoing::SetForNow(int code, std::size_t axis, double value) {
  const auto before = Got(axes_->Field(code, axis));
  if (!before || !Did(axes_->SetField(code, axis, value))) return false;
  for_now_.try_emplace({code, axis}, *before);
  return true;
}

bool MotorDoing::WithoutDelay(std::size_t axis) {
  return !axes_->drawing(axis).is_servo || SetForNow(816, axis, 0);
}

void MotorDoing::KeepAsItIs(int code, std::size_t axis) {
  for_now_.erase({code, axis});
}

bool MotorDoing::PutBack() {
  bool all_are = true;
  for (const auto& [field, value] : std::exchange(for_now_, {})) {
    all_are = Did(axes_->SetField(field.first, field.second, value)) && all_are;
  }
  return all_are;
}

bool MotorDoing::Store(std::size_t axis) {
  return PutBack() && Did(axes_->Store(axis));
}

// The speed first: the log keeps a hundred bytes.
void MotorDoing::LogCondition(double speed_unit_s) {
  Log(condition_->axis,
      fmt::format("at {:g} {}/s: {}",
                  speed_unit_s,
                  axes_->drawing(condition_->axis).unit(),
                  condition_->words));
  logged_.second = condition_->words;
}

void MotorDoing::TryAgainAt(double speed_unit_s) {
  const std::size_t axis = condition_->axis;
  condition_.reset();
  done_.result.ending = Ending::kDone;
  done_.result.fault.clear();
  ++done_.found.retries;
  Say(fmt::format(
      "tried again at {:g} {}/s", speed_unit_s, axes_->drawing(axis).unit()));
}

void MotorDoing::GiveUp() {
  const MotorCondition condition = std::move(condition_).value();
  condition_.reset();
  std::string words = condition.words;
  if (!condition.remedy.empty()) words += ": " + condition.remedy;
  Alert(condition.axis, words);
  if (condition.can_move) {
    SafeSlow(condition.axis);
  } else {
    SafeOff(condition.axis);
  }
}

void MotorDoing::Step(MotorDone step) {
  done_.result.steps.push_back(
      {.procedure = name_,
       .variant = options_.is_as_published ? "as_published" : "corrected",
       .iteration = done_.found.retries + 1,
       .name = std::move(step.quantity),
       .unit = std::move(step.unit),
       .before = step.before.value_or(step.after),
       .has_before = step.before.has_value(),
       .after = step.after,
       .verdict = step.verdict,
       .message = std::move(step.message)});
}

void MotorDoing::Found(const std::string& name,
                       const std::string& unit,
                       const Uncertain& value) {
  done_.result.estimates.push_back({.name = name,
                                    .unit = unit,
                                    .value = value.value,
                                    .sd = value.sd,
                                    .identifiable = value.identifiable,
                                    .budget = value.budget});
}

bool MotorDoing::Absorb(MotorResult inner) {
  const auto append = [](auto* from, auto* to) {
    to->insert(to->end(),
               std::make_move_iterator(from->begin()),
               std::make_move_iterator(from->end()));
  };
  append(&inner.result.messages, &done_.result.messages);
  append(&inner.result.steps, &done_.result.steps);
  append(&inner.result.observability, &done_.result.observability);
  MotorFindings& found = done_.found;
  found.alerts += inner.found.alerts;
  found.retries += inner.found.retries;
  found.warnings += inner.found.warnings;
  found.safe_modes += inner.found.safe_modes;
  if (inner.found.wrong_turn_probability) {
    found.wrong_turn_probability = std::max(found.wrong_turn_probability.value_or(0),
                                            *inner.found.wrong_turn_probability);
  }
  const bool is_done = inner.result.ending == Ending::kDone;
  if (!is_done) {
    done_.result.ending = inner.result.ending;
    done_.result.fault = inner.result.fault;
  }
  return is_done;
}

void MotorDoing::Fail(const MachineFault& fault) {
  done_.result.fault = fault.reply;
  Say(MachineSaid(fault.reply));
  if (auto condition = ConditionOf(fault, axes_->bench().drawing)) {
    Meet(*std::move(condition));
    return;
  }
  done_.result.ending = EndingOfFault(fault);
}

bool MotorDoing::IsHomed(std::size_t axis) {
  const auto says = Got(axes_->Drive(axis));
  if (!says) return false;
  if (says->is_homed) return true;
  Fail({.reply = MotorAxisName(axis) + " is not homed: home it first"});
  return false;
}

std::optional<double> MotorDoing::TopSpeed_unit_s(std::size_t axis) {
  const auto kept_unit_s = Got(axes_->Field(203, axis));
  if (!kept_unit_s) return std::nullopt;
  return std::min(*kept_unit_s, axes_->drawing(axis).max_velocity_unit_s);
}

std::optional<double> MotorDoing::CommonSpeed_unit_s() {
  double slowest_unit_s = std::numeric_limits<double>::max();
  for (const std::size_t axis : options_.axes) {
    const auto top_unit_s = TopSpeed_unit_s(axis);
    if (!top_unit_s) return std::nullopt;
    slowest_unit_s = std::min(slowest_unit_s, *top_unit_s);
  }
  return options_.medium * slowest_unit_s;
}

MotorResult MotorDoing::Take() {
  if (condition_) {
    Log(condition_->axis, condition_->words);
    GiveUp();
  }
  PutBack();
  return std::move(done_);
}

}  // namespace caltwin
