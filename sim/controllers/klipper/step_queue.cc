#include "sim/controllers/klipper/step_queue.h"

#include <algorithm>

namespace caltwin {
namespace klipper {

Clock Extended(std::int64_t clock32, Clock now) {
  const auto ahead =
      static_cast<std::uint32_t>(clock32) - static_cast<std::uint32_t>(now);
  return now + static_cast<std::int32_t>(ahead);
}

Clock StepMove::StepClock(std::int64_t step) const {
  return start + step * interval + add * (step * (step - 1) / 2);
}

bool StepMove::IsOrdered() const {
  return interval > 0 && interval + add * (count - 1) > 0;
}

std::int64_t StepMove::StepsDone(Clock clock) const {
  if (add == 0) return std::clamp((clock - start) / interval, Clock{0}, count);
  std::int64_t done = 0, beyond = count + 1;
  while (beyond - done > 1) {
    const std::int64_t middle = (done + beyond) / 2;
    (StepClock(middle) <= clock ? done : beyond) = middle;
  }
  return done;
}

std::int64_t StepQueue::At(Clock clock) const {
  std::int64_t at = from_;
  for (const StepMove& move : moves_) {
    if (clock < move.start) break;
    at += move.sense * move.StepsDone(clock);
  }
  return at;
}

StepQueue::Fault StepQueue::Append(
    std::int64_t interval, std::int64_t count, std::int64_t add, int sense, Clock now) {
  const Clock first = Extended(last_ + interval, now);
  StepMove move{.start = first - interval,
                .interval = interval,
                .count = count,
                .add = add,
                .sense = sense};
  if (!move.IsOrdered()) return Fault::kTooFarInPast;
  if (first < now) return IsActive(now) ? Fault::kTooFarInPast : Fault::kTooClose;
  moves_.push_back(move);
  last_ = move.end();
  return Fault::kNone;
}

void StepQueue::Stop(Clock clock) {
  from_ = At(clock);
  moves_.clear();
  last_ = 0;
}

void StepQueue::AppendTurns(Clock from, Clock to, std::vector<Clock>* turns) const {
  for (std::size_t i = 1; i < moves_.size(); ++i) {
    const Clock turn = moves_[i - 1].end();
    if (turn > to) return;
    if (turn > from && moves_[i].sense != moves_[i - 1].sense) turns->push_back(turn);
  }
}

void StepQueue::Forget(Clock before) {
  while (!moves_.empty() && moves_.front().end() <= before) {
    from_ += moves_.front().sense * moves_.front().count;
    moves_.pop_front();
  }
}

}  // namespace klipper
}  // namespace caltwin
