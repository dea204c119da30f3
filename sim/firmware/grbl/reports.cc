// What it tells of itself.

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/firmware/grbl/controller.h"
#include "sim/link/gcode.h"

namespace caltwin::grbl {
namespace {

constexpr double kMmPerInch = MmFromInch(1.0);

std::string PlaceText(const Vec3<double>& at_mm, bool in_inches) {
  const Vec3<double> at = in_inches ? Vec3<double>(at_mm / kMmPerInch) : at_mm;
  const int decimals = in_inches ? 4 : 3;
  return fmt::format(
      "{0:.{3}f},{1:.{3}f},{2:.{3}f}", at[0] + 0.0, at[1] + 0.0, at[2] + 0.0, decimals);
}

}  // namespace

std::string Controller::Place(const Vec3<double>& at_mm) const {
  return PlaceText(at_mm, memory_.Is(kReportInches));
}

std::string Controller::ProbeLine() const {
  return fmt::format("[PRB:{}:{}]", Place(probed_mm_), has_probed_ ? 1 : 0);
}

Controller::Lines Controller::ParameterLines() const {
  Lines lines;
  for (int i = 0; i < 6; ++i) {
    lines.push_back(fmt::format(
        "[G{}:{}]", 54 + i, Place(memory_.workplaces_mm[static_cast<std::size_t>(i)])));
  }
  lines.push_back(fmt::format("[G28:{}]", Place(memory_.place_28_mm)));
  lines.push_back(fmt::format("[G30:{}]", Place(memory_.place_30_mm)));
  lines.push_back(fmt::format("[G92:{}]", Place(g92_mm_)));
  const bool in_inches = memory_.Is(kReportInches);
  lines.push_back(
      fmt::format("[TLO:{:.{}f}]",
                  in_inches ? tool_length_mm_ / kMmPerInch : tool_length_mm_,
                  in_inches ? 4 : 3));
  lines.push_back(ProbeLine());
  return lines;
}

std::string Controller::ModalLine() const {
  const std::string motion = modal_.motion >= 382
                                 ? fmt::format("38.{}", modal_.motion - 380)
                                 : fmt::format("{}", modal_.motion);
  const double feed_mm_min = FeedWord_mm_min(modal_.feed_mm_s);
  const bool in_inches = memory_.Is(kReportInches);
  return fmt::format("[GC:G{} G{} G{} G{} G{} G{} M{} M{} T{} F{:.{}f} S{:.0f}]",
                     motion,
                     54 + modal_.workplace,
                     modal_.plane,
                     modal_.is_inches ? 20 : 21,
                     modal_.is_relative ? 91 : 90,
                     modal_.is_inverse_time ? 93 : 94,
                     modal_.spindle,
                     modal_.has_flood ? 8 : 9,
                     modal_.tool,
                     in_inches ? feed_mm_min / kMmPerInch : feed_mm_min,
                     in_inches ? 1 : 0,
                     modal_.spindle_rpm);
}

void Controller::Publish() {
  std::string pins;
  // While it stands: a switch that a move passes is not told of.
  if (!motion_.has_queued()) {
    if (plant_->ProbeTriggered()) pins += 'P';
    for (const Axis axis : kAxes) {
      if (plant_->SwitchClosed(axis)) pins += CapitalLetter(axis);
    }
  }
  const std::lock_guard<std::mutex> lock(live_mutex_);
  live_.is_locked = is_locked_;
  live_.needs_reset = needs_reset_;
  live_.is_checking = is_checking_;
  live_.is_asleep = is_asleep_;
  live_.waiting_moves = motion_.num_queued();
  if (live_.waiting_moves == 0 && !is_performing_) live_.is_jogging = false;
  for (Eigen::Index i = 0; i < 3; ++i) {
    live_.zero_steps[i] = motion_.motor_steps()[i] - motion_.counts()[i];
  }
  live_.steps_per_mm = settings_.steps_per_mm;
  const Vec3<double> offset_mm = WorkOffset_mm(modal_);
  if (offset_mm != live_.offset_mm) until_offset_ = 0;
  live_.offset_mm = offset_mm;
  live_.pins = pins;
  live_.spindle_rpm = modal_.spindle == 5 ? 0 : modal_.spindle_rpm;
  live_.accessories = modal_.spindle == 3 ? "S" : modal_.spindle == 4 ? "C" : "";
  if (modal_.has_flood) live_.accessories += 'F';
  live_.mask = static_cast<unsigned>(memory_.Value(kStatusMask));
  live_.is_inches = memory_.Is(kReportInches);
}

// live_mutex_ is held.
std::string Controller::StateName() const {
  if (live_.is_asleep) return "Sleep";
  if (live_.is_homing) return "Home";
  if (live_.is_locked) return "Alarm";
  if (live_.is_checking) return "Check";
  if (pace_->is_held()) return "Hold:0";
  if (live_.is_jogging) return "Jog";
  return live_.waiting_moves > 0 || pace_->is_moving() ? "Run" : "Idle";
}

std::string Controller::Status(std::size_t rx_free) {
  const Motors steps = pace_->steps();
  const double feed_mm_min = FeedWord_mm_min(pace_->feed_mm_s());
  const std::lock_guard<std::mutex> lock(live_mutex_);
  if (live_.needs_reset) return "";
  Vec3<double> at_mm;
  for (Eigen::Index i = 0; i < 3; ++i) {
    at_mm[i] = (steps[i] - live_.zero_steps[i]) /
               live_.steps_per_mm[static_cast<std::size_t>(i)];
  }
  const std::string state = StateName();
  const bool says_machine = (live_.mask & 1U) != 0;
  if (!says_machine) at_mm -= live_.offset_mm;
  std::string text = fmt::format("<{}|{}:{}",
                                 state,
                                 says_machine ? "MPos" : "WPos",
                                 PlaceText(at_mm, live_.is_inches));
  if ((live_.mask & 2U) != 0) {
    constexpr std::size_t kPlannerBlocks = 15;
    const std::size_t taken = std::min(live_.waiting_moves, kPlannerBlocks);
    text += fmt::format("|Bf:{},{}", kPlannerBlocks - taken, rx_free);
  }
  text += fmt::format("|FS:{:.0f},{:.0f}",
                      live_.is_inches ? feed_mm_min / kMmPerInch : feed_mm_min,
                      live_.spindle_rpm);
  if (!live_.pins.empty()) text += "|Pn:" + live_.pins;
  const bool is_busy = state == "Run" || state == "Home" || state == "Jog";
  if (until_offset_ > 0) {
    --until_offset_;
  } else {
    until_offset_ = is_busy ? 29 : 9;
    if (until_overrides_ == 0) until_overrides_ = 1;
    text += "|WCO:" + PlaceText(live_.offset_mm, live_.is_inches);
  }
  if (until_overrides_ > 0) {
    --until_overrides_;
  } else {
    until_overrides_ = is_busy ? 19 : 9;
    text +=
        fmt::format("|Ov:{},{},{}", feed_percent_, rapid_percent_, spindle_percent_);
    if (!live_.accessories.empty()) text += "|A:" + live_.accessories;
  }
  return text + ">";
}

}  // namespace caltwin::grbl
