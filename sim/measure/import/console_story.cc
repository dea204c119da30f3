#include "sim/measure/import/console_story.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// The key before a colon or equals sign; empty where there is none.
std::string KeyOf(const std::string& lower) {
  const std::size_t end = lower.find_first_of(":=");
  if (end == std::string::npos) return "";
  const std::string key = PlainWord(lower.substr(0, end));
  const bool is_word = !key.empty() && std::ranges::all_of(key, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
  });
  return is_word ? key : "";
}

}  // namespace

bool ConsoleStory::Take(const ConsoleLine& line,
                        const Place& place,
                        const std::string& home) {
  if (IsCommand(line, "m420") || IsCommand(line, "g29")) forgotten_at_ = {};
  if (line.lower.starts_with("[g54:") && has_probed_ && idle_offset_at_.line == 0) {
    const auto offsets_mm = NumbersApart(line.lower.substr(5));
    const bool is_idle = offsets_mm.size() >= 3 && offsets_mm[2] == 0 &&
                         (offsets_mm[0] != 0 || offsets_mm[1] != 0);
    if (is_idle) idle_offset_at_ = place;
    return true;
  }
  return differences_.Take(line.lower) || TakePositions(line) ||
         TakeAdjustment(line, home) || TakeAlignment(line) || TakeCalibration(line) ||
         TakeConfig(line);
}

void ConsoleStory::Touch() {
  has_probed_ = true;
  if (Known(at_mm_[0])) touched_at_mm_.push_back(at_mm_);
  at_mm_ = {kUnknown, kUnknown};
}

void ConsoleStory::Move(const std::array<double, 3>& to_mm) {
  was_moved_ |= !touched_at_mm_.empty();
  if (is_zeroed_) moved_to_mm_ = {to_mm[0], to_mm[1]};
}

// "X:150.000 Y:125.000 Z:5.000 ... Count", "G31 X0 Y25", "G92 X0 Y0", a reported
// z_offset.
bool ConsoleStory::TakePositions(const ConsoleLine& line) {
  if (line.lower.starts_with("x:") && line.lower.find(" y:") != std::string::npos) {
    at_mm_ = {NumberAfter(line.lower, "x:").value_or(kUnknown),
              NumberAfter(line.lower, "y:").value_or(kUnknown)};
    return true;
  }
  if (IsCommand(line, "g31")) {
    trigger_offset_mm_ = {WordOf(line, 'x').value_or(0), WordOf(line, 'y').value_or(0)};
    return true;
  }
  if (IsCommand(line, "g92")) {
    is_zeroed_ = WordOf(line, 'x') == 0.0 && WordOf(line, 'y') == 0.0;
    return true;
  }
  const std::size_t offset = line.lower.find("z_offset: ");
  const bool is_of_place = line.lower.starts_with("probe: z_offset");
  if (offset != std::string::npos && section_.empty() && !is_of_place) {
    const auto result_mm = NumberAfter(line.lower.substr(offset), "z_offset: ");
    if (result_mm) results_mm_.push_back(*result_mm);
    return result_mm.has_value();
  }
  return false;
}

void ConsoleStory::Home(const Place& place) {
  if (was_levelled_ && forgotten_at_.line == 0) forgotten_at_ = place;
}

// "[probe]", "x_offset: 10", "z_positions:" and the pairs below it.
bool ConsoleStory::TakeConfig(const ConsoleLine& line) {
  if (line.lower.starts_with('[') && line.lower.find(']') != std::string::npos &&
      !line.lower.starts_with("[prb")) {
    const std::string name = line.lower.substr(1, line.lower.find(']') - 1);
    // "[...]": lines that somebody left out.
    if (name.find_first_of("abcdefghijklmnopqrstuvwxyz") == std::string::npos)
      return true;
    section_ = PlainWord(name);
    key_.clear();
    return true;
  }
  if (section_.empty()) return false;
  const std::string key = KeyOf(line.lower);
  std::string rest = line.lower;
  if (!key.empty()) {
    key_ = key;
    rest = line.lower.substr(line.lower.find_first_of(":=") + 1);
  }
  const std::vector<double> numbers = NumbersApart(rest);
  const bool is_list =
      line.lower.find_first_not_of(" +-.,0123456789") == std::string::npos;
  if (key.empty() && !is_list) {
    section_.clear();
    return false;
  }
  const bool is_probe = section_ == "probe" || section_ == "bltouch";
  if (is_probe && key == "xoffset" && numbers.size() == 1)
    probe_offset_mm_[0] = numbers[0];
  if (is_probe && key == "yoffset" && numbers.size() == 1)
    probe_offset_mm_[1] = numbers[0];
  const bool is_pivot = key_ == "zpositions" || key_ == "gantrycorners";
  if (is_pivot && numbers.size() == 2) {
    levelling_.pivots_mm.push_back({numbers[0], numbers[1]});
  }
  return true;
}

// "Making the following Z adjustments:", then "stepper_z = 0.2" a line; of
// RepRapFirmware "Leadscrew adjustments made: 0.1 -0.2 0.3, points used 3 ...".
bool ConsoleStory::TakeAdjustment(const ConsoleLine& line, const std::string& home) {
  if (line.lower.starts_with("making the following z adjustments") ||
      line.lower.starts_with("screws_tilt_calculate")) {
    levelling_.rounds.push_back({.home = home});
    levelling_.is_by_hand |= line.lower.starts_with("screws");
    return true;
  }
  if (line.lower.starts_with("stepper_z") &&
      line.lower.find('=') != std::string::npos && !levelling_.rounds.empty()) {
    const auto moved_mm = NumbersApart(line.lower.substr(line.lower.find('=')));
    if (moved_mm.size() != 1) return false;
    levelling_.rounds.back().moved_mm.push_back(moved_mm[0]);
    return true;
  }
  const std::size_t colon = line.lower.find(':');
  if (line.lower.starts_with("leadscrew adjustments made") &&
      colon != std::string::npos) {
    const std::size_t comma = line.lower.find(',', colon);
    levelling_.rounds.push_back(
        {.home = home,
         .moved_mm = NumbersApart(line.lower.substr(colon, comma - colon))});
    return true;
  }
  return false;
}

// Marlin's G34: "Z1-Z2=0.135" a round, "Decreasing Accuracy Detected."
bool ConsoleStory::TakeAlignment(const ConsoleLine& line) {
  const std::size_t at = line.lower.find("z1-z2=");
  if (at != std::string::npos) {
    const auto difference_mm = NumberAfter(line.lower, "z1-z2=");
    if (difference_mm) levelling_.differences_mm.push_back(*difference_mm);
    return true;
  }
  if (line.lower.find("decreasing accuracy detected") != std::string::npos) {
    if (lost_accuracy_after_ == 0) {
      lost_accuracy_after_ = static_cast<int>(levelling_.differences_mm.size());
    }
    return true;
  }
  return false;
}

// RepRapFirmware's own calibration of a delta, and Marlin's of its height.
bool ConsoleStory::TakeCalibration(const ConsoleLine& line) {
  const std::size_t diagonals = line.lower.find("diagonals ");
  if (diagonals != std::string::npos) {
    const auto arms_mm = NumbersApart(line.lower.substr(diagonals, 40));
    if (!arms_mm.empty()) arm_mm_ = arms_mm[0];
    if (!calibrations_.empty()) calibrations_.back().arm_mm = arm_mm_;
    return true;
  }
  if (line.lower.find("endstop adjustments") != std::string::npos) return true;
  if (line.lower.find("average measured backlash") != std::string::npos) {
    has_homed_backlash_ = true;
    return true;
  }
  const std::size_t calibrated = line.lower.find("calibrated ");
  if (calibrated != std::string::npos &&
      line.lower.find("factors") != std::string::npos) {
    calibrations_.push_back(
        {.factors = NumberAfter(line.lower, "calibrated ").value_or(0),
         .after_mm = NumberAfter(line.lower, "after ").value_or(kUnknown)});
    return true;
  }
  const bool is_iteration = line.lower.find("iteration") != std::string::npos;
  if (const auto deviation_mm = NumberAfter(line.lower, "std dev:");
      is_iteration && deviation_mm) {
    deviations_mm_.push_back(*deviation_mm);
    return true;
  }
  if (line.lower.find(".height:") != std::string::npos) {
    const auto height_mm = NumberAfter(line.lower, "height:");
    if (height_mm && (heights_.empty() || Known(heights_.back().middle_mm))) {
      // The height after a calibration stands before the next one, too.
      if (heights_.empty() || heights_.back().height_mm != *height_mm) {
        heights_.push_back({.height_mm = *height_mm});
      }
    }
    const auto middle_mm = NumberAfter(line.lower, "c:");
    if (middle_mm && !heights_.empty()) heights_.back().middle_mm = *middle_mm;
    return true;
  }
  const std::size_t middle = line.lower.find(" c:");
  if (middle != std::string::npos && !heights_.empty() &&
      !Known(heights_.back().middle_mm)) {
    const auto numbers = NumbersApart(line.lower.substr(middle));
    if (!numbers.empty()) heights_.back().middle_mm = numbers[0];
    return true;
  }
  return false;
}

// A correction that works, and then is turned round behind a message.
void ConsoleStory::TellAlignment(Imported* imported) const {
  const std::vector<double>& all_mm = levelling_.differences_mm;
  constexpr double kWorks = 0.3;
  if (all_mm.size() < 3 || lost_accuracy_after_ < 2) return;
  if (std::abs(all_mm[1]) > kWorks * std::abs(all_mm[0])) return;
  int worse = 0;
  for (std::size_t i = 2; i < all_mm.size(); ++i) {
    worse += std::abs(all_mm[i]) > 1.2 * std::abs(all_mm[i - 1]) ? 1 : 0;
  }
  if (worse == 0) return;
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "firmware",
       .sentence = fmt::format(
           "The motors are the right way round: the first round took {:.0f} % of the "
           "difference away. It gets worse only behind the message of decreasing "
           "accuracy, "
           "after which this firmware turns the sense of its correction. Update it, or "
           "ask "
           "for a coarser accuracy",
           100 * (1 - std::abs(all_mm[1] / all_mm[0])))});
}

// A fit that is as good with every length of the arms.
void ConsoleStory::TellCalibrations(Imported* imported) const {
  constexpr double kLeastChange = 0.005, kAlike_mm = 0.02;
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL, after_mm = 0;
  double after_least_mm = HUGE_VAL;
  int num = 0;
  for (const Calibration& one : calibrations_) {
    if (!Known(one.arm_mm) || !Known(one.after_mm)) continue;
    least_mm = std::min(least_mm, one.arm_mm);
    most_mm = std::max(most_mm, one.arm_mm);
    after_mm = std::max(after_mm, one.after_mm);
    after_least_mm = std::min(after_least_mm, one.after_mm);
    ++num;
  }
  const bool wanders = num >= 2 && most_mm - least_mm > kLeastChange * most_mm &&
                       after_mm - after_least_mm < kAlike_mm;
  if (!wanders) return;
  imported->notes.push_back(
      {.kind = FileNote::Kind::kOpen,
       .what = "arm_length",
       .sentence = fmt::format(
           "the length of the arms: it went from {:.1f} to {:.1f} mm in {} "
           "calibrations that "
           "all fit to {:.3f} mm. Heights of a bed do not tell it; enter what the arms "
           "measure, calibrate six factors, and check a printed length",
           most_mm,
           least_mm,
           num,
           after_mm)});
}

// What a firmware's own calibration came to: it settles, or runs away.
void ConsoleStory::TellDeviations(Imported* imported) const {
  constexpr std::size_t kFewest = 3;
  constexpr double kWorse = 2;
  if (deviations_mm_.size() < kFewest) return;
  const double last_mm = deviations_mm_.back();
  const double least_mm = std::ranges::min(deviations_mm_);
  const std::string course = fmt::format("{:.3f} mm after {} iterations, from {:.3f}",
                                         last_mm,
                                         deviations_mm_.size(),
                                         deviations_mm_.front());
  if (last_mm > kWorse * least_mm) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "firmware",
         .sentence = fmt::format(
             "The firmware's calibration runs away: its standard deviation is {}, and "
             "was {:.3f} in between. Do not save it; begin again from the drawing's "
             "figures, with fewer points",
             course,
             least_mm)});
    return;
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kOpen,
       .what = "cause",
       .sentence = fmt::format(
           "what is left of the firmware's own calibration, a standard deviation of "
           "{}: "
           "the probe's scatter (M48 tells it), or what its model has no number for, a "
           "bed that is not flat, towers that lean",
           course)});
}

// A height that is corrected, and a reading that does not answer to it.
void ConsoleStory::TellHeights(Imported* imported) const {
  constexpr std::size_t kFewest = 3;
  constexpr double kAlike = 0.2, kLeast_mm = 0.05;
  std::size_t alike = 0;
  for (std::size_t k = 1; k < heights_.size(); ++k) {
    const Height &before = heights_[k - 1], &now = heights_[k];
    if (!Known(before.middle_mm) || !Known(now.middle_mm)) continue;
    const double corrected_mm = before.height_mm - now.height_mm;
    const bool is_applied =
        std::abs(corrected_mm - before.middle_mm) < 0.2 * std::abs(before.middle_mm);
    const bool is_same = std::abs(now.middle_mm - before.middle_mm) <
                         kAlike * std::abs(before.middle_mm);
    alike += std::abs(now.middle_mm) > kLeast_mm && is_applied && is_same ? 1 : 0;
  }
  if (alike + 1 < kFewest) return;
  const auto last_read =
      std::ranges::find_if(heights_.rbegin(), heights_.rend(), [](const Height& one) {
        return Known(one.middle_mm);
      });
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "firmware",
       .sentence = fmt::format("The height is corrected each time ({:.2f} to {:.2f} "
                               "mm) and the reading does not "
                               "answer to it ({:.2f} mm again): a height that is "
                               "really corrected reads near 0 the "
                               "second time. This firmware's probing is at fault, not "
                               "the printer. Do not save; "
                               "go back to the height that worked",
                               heights_.front().height_mm,
                               heights_.back().height_mm,
                               last_read->middle_mm)});
}

// Touches that walk away by the probe's offset, results that take turns, a touch that
// was never written into the work offset.
void ConsoleStory::TellProbing(Imported* imported) const {
  constexpr double kAlike_mm = 0.5;
  constexpr std::size_t kFewest = 3;
  bool walks = touched_at_mm_.size() >= kFewest && !was_moved_;
  for (std::size_t i = 1; i < touched_at_mm_.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double step_mm = touched_at_mm_[i][k] - touched_at_mm_[i - 1][k];
      walks &=
          std::abs(std::abs(step_mm) - std::abs(trigger_offset_mm_[k])) < kAlike_mm;
    }
  }
  const bool has_offset = std::hypot(trigger_offset_mm_[0], trigger_offset_mm_[1]) > 1;
  if (walks && has_offset) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "firmware",
         .sentence =
             fmt::format("The touches are not at one place: after each the head stands "
                         "{:g} mm further, "
                         "the probe's offset of G31. What changes from touch to touch "
                         "is the slope of the "
                         "bed over that distance, no drift of the probe. Give X and Y "
                         "with every G30",
                         std::hypot(trigger_offset_mm_[0], trigger_offset_mm_[1]))});
  }
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL, apart_mm = HUGE_VAL;
  for (std::size_t i = 1; i < results_mm_.size(); ++i) {
    const double sum_mm = results_mm_[i] + results_mm_[i - 1];
    least_mm = std::min(least_mm, sum_mm);
    most_mm = std::max(most_mm, sum_mm);
    apart_mm = std::min(apart_mm, std::abs(results_mm_[i] - results_mm_[i - 1]));
  }
  if (results_mm_.size() > kFewest && apart_mm > 5 * (most_mm - least_mm)) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "firmware",
         .sentence = fmt::format("The results take turns, {:.3f} and {:.3f}: each "
                                 "calibration takes the offset "
                                 "already set off the reading once more (new = true - "
                                 "old). Nothing mechanical "
                                 "alternates with saving. The true one is that found "
                                 "with 0 set; do not repeat it "
                                 "with it set, or update",
                                 results_mm_[0],
                                 results_mm_[1])});
  }
  if (idle_offset_at_.line > 0) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "work_offset",
         .sentence = fmt::format(
             "line {}: the touch was found and nothing was done with it: Z of G54 is "
             "still 0, "
             "so the display shows the machine's own height. While touching, G10 L20 "
             "P1 "
             "Z(thickness of the plate) sets it. One touch says nothing about the axis",
             idle_offset_at_.line),
         .place = idle_offset_at_});
  }
}

// The head was moved by as much as the offset says to bring the probe to where the
// nozzle had been: then the probe stands the other way.
void ConsoleStory::TellSigns(Imported* imported) const {
  constexpr double kAlike_mm = 0.05;
  if (!Known(moved_to_mm_[0]) || !Known(probe_offset_mm_[0])) return;
  for (std::size_t k = 0; k < 2; ++k) {
    const double is_mm = probe_offset_mm_[k], should_mm = -moved_to_mm_[k];
    if (!Known(is_mm) || std::abs(is_mm) < 1 ||
        std::abs(is_mm + should_mm) > kAlike_mm) {
      continue;
    }
    imported->notes.push_back(
        {.kind = FileNote::Kind::kSetting,
         .what = k == 0 ? "x_offset" : "y_offset",
         .sentence = fmt::format(
             "{0}_offset is {1:g} and should be {2:g}: the head had to go {3:+g} to "
             "bring the "
             "probe to where the nozzle was, so the probe stands at {2:+g} from it. As "
             "written, every touch is taken {4:g} mm from where it is believed",
             "xy"[k],
             is_mm,
             should_mm,
             moved_to_mm_[k],
             2 * std::abs(is_mm))});
  }
}

void ConsoleStory::Tell(Imported* imported) const {
  imported->levelling = levelling_;
  TellProbing(imported);
  TellSigns(imported);
  if (forgotten_at_.line > 0) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "file",
         .sentence = fmt::format("line {}: homing after G29 switches the levelling off "
                                 "in Marlin, and nothing "
                                 "behind it switches it on again. In the start code "
                                 "G29 comes last, or M420 S1 "
                                 "after the last G28",
                                 forgotten_at_.line),
         .place = forgotten_at_});
  }
  if (has_homed_backlash_) {
    for (const char* axis : {"x", "y", "z"}) {
      imported->notes.push_back(
          {.kind = FileNote::Kind::kOpen,
           .what = fmt::format("backlash.{}", axis),
           .sentence = fmt::format("lost motion of {}: M425 measures it by homing, and "
                                   "a switch alone opens as much "
                                   "later as it closed. Set a dial against the axis "
                                   "and come from both sides",
                                   static_cast<char>(axis[0] - 'a' + 'A'))});
    }
    imported->next_instrument = "dial";
  }
  TellAlignment(imported);
  TellCalibrations(imported);
  TellHeights(imported);
  TellDeviations(imported);
  differences_.Tell(imported);
}

}  // namespace caltwin
