#include "sim/firmware/grbl/memory.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/firmware/grbl/block.h"
#include "sim/link/gcode.h"

namespace caltwin::grbl {
namespace {

/// Settings printed with three decimals; the others are whole.
bool IsFraction(int number) {
  return number == 11 || number == kArcTolerance || number == kHomingFeed ||
         number == kHomingSeek || number == kHomingPullOff || number >= kStepsPerMm;
}

/// Settings that are on or off, however large a number is written.
bool IsSwitch(int number) {
  return (number >= 4 && number <= 6) || number == kReportInches ||
         (number >= kSoftLimits && number <= kHomingCycle) || number == 32;
}

}  // namespace

Memory::Memory(const Machine& machine, const Settings& believed) {
  values_ = {{0, 10},
             {1, 25},
             {2, 0},
             {3, 0},
             {4, 0},
             {5, 0},
             {6, 0},
             {kStatusMask, 1},
             {11, 0.01},
             {kArcTolerance, 0.002},
             {kReportInches, 0},
             {kSoftLimits, 1},
             {kHardLimits, 0},
             {kHomingCycle, 1},
             {kHomingMask, 0},
             {kHomingFeed, 60},
             {kHomingSeek, 1200},
             {26, 250},
             {kHomingPullOff, 2},
             {30, 1000},
             {31, 0},
             {32, 0}};
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    const int i = Index(axis);
    if (drawing.home == HomeEnd::kMin) values_[kHomingMask] += 1 << i;
    values_[kStepsPerMm + i] = believed.steps_per_mm[static_cast<std::size_t>(i)];
    values_[kMaxRate + i] = FeedWord_mm_min(drawing.max_feed_mm_s);
    values_[kAcceleration + i] = drawing.acceleration_mm_s2;
    values_[kMaxTravel + i] = drawing.travel_mm();
  }
  first_ = values_;
  ForgetPlaces();
}

void Memory::ForgetPlaces() {
  workplaces_mm.fill(Vec3<double>::Zero());
  place_28_mm = place_30_mm = Vec3<double>::Zero();
}

void Memory::Set(int number, double value) {
  const auto setting = values_.find(number);
  if (setting == values_.end()) throw LineError(kInvalidStatement);
  if (value < 0) throw LineError(kNegativeValue);
  constexpr double kLargest = 1e7, kShortestPulse_us = 3;
  // Nothing moves at 0 of it.
  const bool divides = number >= kStepsPerMm ||
                       (number >= kHomingFeed && number <= kHomingSeek) ||
                       number == kHomingPullOff;
  if (value > kLargest || (divides && value == 0)) throw LineError(kInvalidStatement);
  if (number == 0 && value < kShortestPulse_us) throw LineError(kPulseTooShort);
  if (number == kSoftLimits && value != 0 && !Is(kHomingCycle))
    throw LineError(kSoftLimitsNeedHoming);
  if (IsSwitch(number)) {
    value = value != 0 ? 1 : 0;
  } else if (!IsFraction(number)) {
    value = std::floor(value);
  }
  setting->second = value;
  if (number == kHomingCycle && value == 0) values_[kSoftLimits] = 0;
}

std::vector<std::string> Memory::Lines() const {
  std::vector<std::string> lines;
  for (const auto& [number, value] : values_) {
    lines.push_back(IsFraction(number) ? fmt::format("${}={:.3f}", number, value)
                                       : fmt::format("${}={:.0f}", number, value));
  }
  return lines;
}

}  // namespace caltwin::grbl
