#include "tools/commands/api/client_operator.h"

#include <utility>

#include <fmt/format.h>

#include "scenarios/interruptible_link.h"

namespace caltwin {
namespace {

tl::unexpected<MachineFault> Refused(const std::string& why) {
  return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, why});
}

std::string KindOf(Act::Kind kind) {
  switch (kind) {
    case Act::Kind::kConfirm:
      return "confirm";
    case Act::Kind::kTurnBlock:
      return "turn_block";
    case Act::Kind::kFitStylus:
      return "fit_stylus";
    case Act::Kind::kOther:
      break;
  }
  return "other";
}

}  // namespace

nlohmann::ordered_json ToJson(const Question& question) {
  nlohmann::ordered_json tree{
      {"id", question.id}, {"kind", question.kind}, {"text", question.text}};
  if (!question.gauge.empty()) tree["gauge"] = question.gauge;
  if (question.hint_mm) tree["hint_mm"] = *question.hint_mm;
  return tree;
}

Expected<ClientOperator::Answered> ClientOperator::Ask(Question question) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_aborted_) return Refused("aborted by the operator");
    question.id = ++last_;
    question_ = std::move(question);
    answer_.reset();
  }
  asked_();
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return answer_.has_value() || is_aborted_; });
  question_.reset();
  const std::optional<Answered> answer = answer_;
  lock.unlock();
  asked_();
  if (!answer) return Refused("aborted by the operator");
  return *answer;
}

Expected<void> ClientOperator::Do(const Act& act) {
  const auto answer = Ask({.kind = KindOf(act.kind), .text = act.text});
  if (!answer) return tl::unexpected(answer.error());
  if (!answer->is_yes) return Refused("the operator says no");
  const bool needs_hands = act.kind != Act::Kind::kConfirm && helpers_.hands != nullptr;
  return needs_hands ? helpers_.hands->Do(act) : Expected<void>{};
}

Expected<double> ClientOperator::Read_mm(std::string_view id) {
  Question question{.kind = "reading",
                    .text = fmt::format("Read {} and enter it.", id),
                    .gauge = std::string(id)};
  if (helpers_.gauge != nullptr) {
    if (const auto read_mm = helpers_.gauge->Read_mm(id)) question.hint_mm = *read_mm;
  }
  const auto answer = Ask(question);
  if (!answer) return tl::unexpected(answer.error());
  if (answer->value_mm) return *answer->value_mm;
  return Refused("the operator has no reading");
}

Expected<void> ClientOperator::Zero(std::string_view id) {
  const auto answer =
      Ask({.kind = "zero",
           .text = fmt::format("Set {} against the axis and zero it.", id),
           .gauge = std::string(id)});
  if (!answer) return tl::unexpected(answer.error());
  if (!answer->is_yes) return Refused("the operator says no");
  return helpers_.gauge != nullptr ? helpers_.gauge->Zero(id) : Expected<void>{};
}

bool ClientOperator::Answer(int id, bool is_yes, std::optional<double> value_mm) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!question_ || question_->id != id || answer_) return false;
  answer_ = Answered{.is_yes = is_yes, .value_mm = value_mm};
  changed_.notify_all();
  return true;
}

std::optional<Question> ClientOperator::question() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return question_;
}

void ClientOperator::Abort() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_aborted_ = true;
  changed_.notify_all();
}

void ClientOperator::Begin() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_aborted_ = false;
}

Expected<std::vector<std::string>> AbortableLink::Send(
    std::string_view line, std::chrono::milliseconds patience) {
  if ((seat_->is_aborted() || InterruptRequested()) && !PutsBack(line))
    return Refused("aborted by the operator");
  auto answer = inner_->Send(line, patience);
  sent_(line);
  return answer;
}

}  // namespace caltwin
