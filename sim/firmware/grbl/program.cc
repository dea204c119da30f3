// Lines of G-code.

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/firmware/grbl/controller.h"
#include "sim/firmware/planner.h"
#include "sim/link/gcode.h"

namespace caltwin::grbl {
namespace {

constexpr double kFarthest_mm = 1e6;  // Beyond what any machine has.
constexpr double kSlowest_mm_s = 1e-3;
constexpr double kLimitSlack_mm = 1e-3;  // Less than any axis resolves.

bool IsProbe(int motion) {
  return motion >= 382 && motion <= 385;
}

}  // namespace

std::optional<double> Controller::TakeLength_mm(Block* block, char letter) const {
  const auto value = block->Take(letter);
  if (!value) return std::nullopt;
  return block->modal.is_inches ? MmFromInch(*value) : *value;
}

Vec3<double> Controller::TakeTarget_mm(Block* block) const {
  Vec3<double> target_mm = At_mm();
  const Vec3<double> offset_mm = WorkOffset_mm(block->modal);
  for (const Axis axis : kAxes) {
    const auto word_mm = TakeLength_mm(block, CapitalLetter(axis));
    if (!word_mm) continue;
    double& coordinate_mm = target_mm[Index(axis)];
    if (block->non_modal == 53) {
      coordinate_mm = *word_mm;
    } else if (block->modal.is_relative) {
      coordinate_mm += *word_mm;
    } else {
      coordinate_mm = *word_mm + offset_mm[Index(axis)];
    }
    if (std::abs(coordinate_mm) > kFarthest_mm) throw LineError(kInvalidTarget);
  }
  return target_mm;
}

void Controller::ObeyBlock(Block block) {
  Deeds deeds;
  if (const auto rpm = block.Take('S')) block.modal.spindle_rpm = *rpm;
  if (const auto tool = block.Take('T')) {
    constexpr double kLastTool = 255;
    if (*tool > kLastTool) throw LineError(kNoSuchTool);
    block.modal.tool = static_cast<int>(*tool);
  }
  TakeFeed(&block);
  TakeAlone(&block, &deeds);
  if (block.cancels_tool_length) {
    deeds.emplace_back([this] { tool_length_mm_ = 0; });
  } else if (block.axis_command == Block::AxisCommand::kToolLength) {
    if (block.Value('X') || block.Value('Y') || !block.Value('Z'))
      throw LineError(kToolLengthAxis);
    const double length_mm = TakeLength_mm(&block, 'Z').value_or(0);
    deeds.emplace_back([this, length_mm] { tool_length_mm_ = length_mm; });
  }
  if (block.axis_command == Block::AxisCommand::kMotion) TakeMotion(&block, &deeds);
  if (block.HasValues()) throw LineError(kUnusedWords);

  modal_ = block.modal;
  for (const auto& deed : deeds) {
    if (!needs_reset_ && !motion_.alarm()) deed();
  }
  if (block.program >= 0 && !needs_reset_) EndProgram(block.program);
}

void Controller::TakeFeed(Block* block) const {
  const bool needs_feed = block->axis_command == Block::AxisCommand::kMotion &&
                          block->modal.motion != kRapid &&
                          block->modal.motion != kNoMotion;
  if (block->modal.is_inverse_time) {
    const auto per_min = block->Take('F');  // No length, whatever the units.
    if (needs_feed && !per_min) throw LineError(kUndefinedFeed);
    block->modal.feed_mm_s = FeedFromWord_mm_s(per_min.value_or(0));
    return;
  }
  const auto word = TakeLength_mm(block, 'F');
  if (block->sets_feed_mode && modal_.is_inverse_time) block->modal.feed_mm_s = 0;
  if (word) block->modal.feed_mm_s = FeedFromWord_mm_s(*word);
  if (needs_feed && block->modal.feed_mm_s == 0) throw LineError(kUndefinedFeed);
}

// Commands of group 0: of this line alone.
void Controller::TakeAlone(Block* block, Deeds* deeds) {
  switch (block->non_modal) {
    case 4: {
      const auto s = block->Take('P');
      if (!s) throw LineError(kValueMissing);
      if (!is_checking_)
        deeds->emplace_back([this, s = *s] {
          motion_.Finish();
          Publish();
          motion_.Dwell(s);
        });
      break;
    }
    case 10:
      TakeWorkplace(block, deeds);
      break;
    case 28:
    case 30: {
      const Vec3<double> stored_mm =
          block->non_modal == 28 ? memory_.place_28_mm : memory_.place_30_mm;
      const bool goes_over = block->has_axis_words();
      Vec3<double> place_mm = goes_over ? At_mm() : stored_mm;
      for (const Axis axis : kAxes) {
        if (block->Value(CapitalLetter(axis)))
          place_mm[Index(axis)] = stored_mm[Index(axis)];
      }
      const Vec3<double> over_mm = TakeTarget_mm(block);
      deeds->emplace_back([this, goes_over, over_mm, place_mm] {
        if (goes_over) GoToPlace(over_mm);
        GoToPlace(place_mm);
      });
      break;
    }
    case 281:
      deeds->emplace_back([this] { memory_.place_28_mm = At_mm(); });
      break;
    case 301:
      deeds->emplace_back([this] { memory_.place_30_mm = At_mm(); });
      break;
    case 92: {
      if (!block->has_axis_words()) throw LineError(kNoAxisWords);
      Vec3<double> g92_mm = g92_mm_;
      const Vec3<double> offset_mm = WorkOffset_mm(block->modal) - g92_mm_;
      for (const Axis axis : kAxes) {
        const auto word_mm = TakeLength_mm(block, CapitalLetter(axis));
        if (!word_mm) continue;
        const int i = Index(axis);
        g92_mm[i] = At_mm()[i] - offset_mm[i] - *word_mm;
      }
      deeds->emplace_back([this, g92_mm] { g92_mm_ = g92_mm; });
      break;
    }
    case 921:
      deeds->emplace_back([this] { g92_mm_.setZero(); });
      break;
    default:
      break;
  }
}

void Controller::TakeWorkplace(Block* block, Deeds* deeds) {
  if (!block->has_axis_words()) throw LineError(kNoAxisWords);
  const auto place = block->Take('P'), kind = block->Take('L');
  if (!place && !kind) throw LineError(kValueMissing);
  const auto most = static_cast<double>(memory_.workplaces_mm.size());
  if (place.value_or(0) > most) throw LineError(kNoSuchWorkplace);
  const bool is_here = kind.value_or(0) == 20;
  if ((kind.value_or(0) != 2 && !is_here) || block->Value('R'))
    throw LineError(kUnsupported);
  const int named = static_cast<int>(place.value_or(0));
  const auto k =
      static_cast<std::size_t>(named == 0 ? block->modal.workplace : named - 1);
  Vec3<double> at_mm = memory_.workplaces_mm[k];
  for (const Axis axis : kAxes) {
    const auto word_mm = TakeLength_mm(block, CapitalLetter(axis));
    if (!word_mm) continue;
    const int i = Index(axis);
    const double length_mm = axis == Axis::kZ ? tool_length_mm_ : 0;
    at_mm[i] = is_here ? At_mm()[i] - g92_mm_[i] - length_mm - *word_mm : *word_mm;
  }
  deeds->emplace_back([this, k, at_mm] { memory_.workplaces_mm[k] = at_mm; });
}

void Controller::TakeMotion(Block* block, Deeds* deeds) {
  const int motion = block->modal.motion;
  const bool has_words = block->has_axis_words();
  if (motion == kNoMotion) {
    if (has_words) throw LineError(kUnusedAxisWords);
    return;
  }
  if (block->non_modal == 53 && motion != kRapid && motion != kLinear)
    throw LineError(kNotWithG53);
  if (!has_words && motion != kRapid && motion != kLinear)
    throw LineError(kNoAxisWords);
  if (!has_words) return;
  const bool names_plane =
      (block->modal.plane != 19 && block->Value('X').has_value()) ||
      (block->modal.plane != 18 && block->Value('Y').has_value()) ||
      (block->modal.plane != 17 && block->Value('Z').has_value());
  const Vec3<double> target_mm = TakeTarget_mm(block);
  double feed_mm_s = block->modal.feed_mm_s;
  const double way_mm = (target_mm - At_mm()).norm();
  if (block->modal.is_inverse_time && motion == kLinear) feed_mm_s *= way_mm;
  if (motion == kRapid) {
    feed_mm_s = std::numeric_limits<double>::infinity();
  }
  if (motion == kClockwise || motion == kCounterClockwise) {
    if (!names_plane) throw LineError(kArcOutOfPlane);
    const Arc arc = TakeArc(block, target_mm);
    if (block->modal.is_inverse_time) feed_mm_s *= arc.length_mm();
    deeds->emplace_back([this, arc, feed_mm_s] { MoveAlong(arc, feed_mm_s); });
  } else if (IsProbe(motion)) {
    if (way_mm == 0) throw LineError(kInvalidTarget);
    deeds->emplace_back([this, target_mm, motion] { Probe(target_mm, motion); });
  } else {
    deeds->emplace_back([this, target_mm, feed_mm_s] { MoveTo(target_mm, feed_mm_s); });
  }
}

bool Controller::IsBeyondLimits(const Vec3<double>& target_mm) const {
  for (int i = 0; i < 3; ++i) {
    const double travel_mm = memory_.Value(kMaxTravel + i);
    if (target_mm[i] > kLimitSlack_mm || target_mm[i] < -travel_mm - kLimitSlack_mm)
      return true;
  }
  return false;
}

bool Controller::RefuseBeyondLimits(const Vec3<double>& target_mm) {
  if (memory_.Is(kSoftLimits)) {
    if (!IsBeyondLimits(target_mm)) return false;
    motion_.Finish();
    LockUntilReset(Alarm::kSoftLimit);
    return true;
  }
  // Where a carriage would meet the end of its rail.
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine_.axis(axis);
    const double mm = target_mm[Index(axis)];
    if (!motion_.is_homed(axis) || (mm > drawing.min_mm - 1 && mm < drawing.max_mm + 1))
      continue;
    motion_.Finish();
    LockUntilReset(Alarm::kHardLimit);
    return true;
  }
  return false;
}

void Controller::MoveTo(const Vec3<double>& target_mm, double feed_mm_s) {
  if (needs_reset_ || RefuseBeyondLimits(target_mm)) return;
  if (is_checking_) {
    checked_mm_ = target_mm;
    return;
  }
  const auto [feed_part, rapid_part] = FeedAndRapidPart();
  const Vec3<double> way_mm = target_mm - At_mm();
  if (std::isfinite(feed_mm_s)) {
    feed_mm_s = std::max(feed_mm_s * feed_part, kSlowest_mm_s);
  } else if (rapid_part < 1 && way_mm.norm() > 0) {
    feed_mm_s = rapid_part * MakeMove(way_mm, feed_mm_s, motion_.limits()).feed_mm_s;
  }
  motion_.MoveTo(target_mm, feed_mm_s);
}

std::array<double, 2> Controller::FeedAndRapidPart() const {
  const std::lock_guard<std::mutex> lock(live_mutex_);
  return {feed_percent_ / 100.0, rapid_percent_ / 100.0};
}

void Controller::GoToPlace(const Vec3<double>& place_mm) {
  MoveTo(place_mm, std::numeric_limits<double>::infinity());
}

void Controller::Probe(const Vec3<double>& target_mm, int mode) {
  if (RefuseBeyondLimits(target_mm)) return;
  if (is_checking_) {
    checked_mm_ = target_mm;
    return;
  }
  motion_.Finish();
  if (motion_.alarm()) return;
  Publish();
  const bool goes_away = mode >= 384;
  const bool must_find = mode == 382 || mode == 384;
  has_probed_ = false;
  if (plant_->ProbeTriggered() != goes_away) {
    // Its answer is ok all the same: the alarm says what there is.
    return Lock(Alarm::kProbeBefore);
  }
  const Motion::Probed probed = motion_.Probe(
      target_mm,
      modal_.feed_mm_s,
      goes_away ? Watch::Kind::kProbeReleased : Watch::Kind::kProbeTriggered,
      Motion::AtTrigger::kBrakes);
  if (motion_.alarm()) return;
  has_probed_ = probed.stopped;
  // One that fails leaves the place of the one before.
  if (probed.stopped || !must_find) probed_mm_ = probed.at_mm;
  if (!probed.stopped && must_find) Lock(Alarm::kNoContact);
  said_.push_back(ProbeLine());
}

void Controller::EndProgram(int program) {
  if (program == 1) return;  // It has no switch that would make it pause.
  motion_.Finish();
  if (motion_.alarm()) return;
  Publish();
  if (program == 0) {
    if (is_checking_) return;
    pace_->Hold();
    if (!pace_->WaitWhileHeld()) says_ok_ = false;
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    feed_percent_ = rapid_percent_ = spindle_percent_ = 100;
  }
  const Modal before = modal_;
  modal_ = Modal{.motion = kLinear,
                 .is_inches = before.is_inches,
                 .tool = before.tool,
                 .feed_mm_s = before.feed_mm_s,
                 .spindle_rpm = before.spindle_rpm};
  said_.emplace_back("[MSG:Pgm End]");
}

}  // namespace caltwin::grbl
