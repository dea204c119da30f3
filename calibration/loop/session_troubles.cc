// What a session says of its troubles, and looks up once more to say it.
#include <fmt/format.h>

#include "calibration/loop/session.h"

namespace caltwin {
namespace {

constexpr std::string_view TitleOf(Trouble trouble) {
  switch (trouble) {
    case Trouble::kNoTrigger:
      return "Probe failed to trigger";
    case Trouble::kInconsistent:
      return "Measurements inconsistent";
    case Trouble::kUnreasonable:
      return "Calculated value unreasonable";
    case Trouble::kWorse:
      break;
  }
  return "Compensation made things worse";
}

bool IsAlreadyTriggered(const MachineFault& fault) {
  return fault.reply.find("already triggered") != std::string::npos;
}

}  // namespace

void Session::Tell(Trouble trouble, const std::string& why) {
  if (why.empty() || is_as_published()) {
    Tell({RemedyFor(trouble), Message::Kind::kToDo});
  }
  if (why.empty()) return;
  Tell({fmt::format("{}: {}.", TitleOf(trouble), why), Message::Kind::kCause});
}

void Session::TellWhyProbeFailed(const MachineFault& fault) {
  using End = FailedProbeMove::End;
  const Ending ending = result_.ending;
  const bool is_bent = ending == Ending::kCollision;
  const bool is_refused = ending == Ending::kRefused;
  if (!is_bent && !is_refused && ending != Ending::kNoTrigger) return;
  const auto move = controller_.failed_probe_move();
  FailedProbeMove failed{.end = is_bent      ? End::kBent
                                : is_refused ? End::kTriggeredBefore
                                             : End::kNothingMet};
  // Nothing moves with a bent stylus, nor up under the lip that a move up was to touch.
  const bool may_raise = !is_bent && move && move->target_mm[2] <= move->from_mm[2];
  if (may_raise) probing_.Raise();
  if (is_bent || move) failed.after = controller_.ReadProbe();
  if (is_refused && !(move && IsAlreadyTriggered(fault)) &&
      failed.after != ProbeReading::kMissing) {
    return;
  }
  if (move) {
    failed.ahead = FindContactAhead(
        bench_->artefacts, *move, controller_.settings().tip_radius_mm);
    if (may_raise) failed = LookAgain(*move, failed);
  }
  const std::string why = WhyProbeFailed(failed);
  if (is_bent && why.empty()) {
    Tell(
        {"The stylus ran into something: the way to the next point led through the "
         "block. Restart the machine and home it before going on.",
         Message::Kind::kCause});
    return;
  }
  Tell(Trouble::kNoTrigger, why);
}

// The move once more after homing, where it was to meet something and the probe has
// proved that it triggers: what is then met had been out of place.
FailedProbeMove Session::LookAgain(const ProbeMove& move, FailedProbeMove failed) {
  const bool is_worth_it = failed.end == FailedProbeMove::End::kNothingMet &&
                           failed.after == ProbeReading::kFree && failed.ahead &&
                           failed.ahead->beyond_mm > 0 && probing_.touches() > 0 &&
                           !is_as_published();
  if (!is_worth_it || !probing_.Home()) return failed;
  Vec3<double> over_mm = move.from_mm;
  over_mm[2] = controller_.position_mm()[2];
  const bool is_there = controller_.MoveTo(over_mm) && controller_.MoveTo(move.from_mm);
  if (!is_there) return failed;
  failed.was_tried_again = true;
  if (controller_.ProbeTowards(move.target_mm, move.feed_mm_s)) {
    const Vec3<double> way_mm = move.target_mm - move.from_mm;
    const Vec3<double> gone_mm = controller_.position_mm() - move.from_mm;
    failed.found_again_mm = gone_mm.dot(way_mm.normalized()) - failed.ahead->after_mm;
  }
  probing_.Raise();
  return failed;
}

}  // namespace caltwin
