#include "calibration/loop/troubles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSure = 3;  // Standard uncertainties.

// What a search that met nothing tells, the probe reading free afterwards.
std::string WhyNothingMet(const FailedProbeMove& failed) {
  if (!failed.ahead) {
    return "no surface of the papers lies in the way of the move: look at its start "
           "and its target";
  }
  const ContactAhead& ahead = *failed.ahead;
  if (ahead.beyond_mm <= 0) {
    return fmt::format(
        "the target does not lie beyond the surface: the move ended {:.1f} mm before "
        "it "
        "would touch {}. The probe reads free, as it should; aim behind the surface",
        -ahead.beyond_mm,
        ahead.feature);
  }
  if (failed.found_again_mm) {
    return fmt::format(
        "the machine had lost its place: nothing was met up to {:.1f} mm behind {}, "
        "and "
        "after homing the same move met it {:+.3f} mm from where it is entered. The "
        "probe works and the target is right: look for lost steps (acceleration, "
        "current, what jams)",
        ahead.beyond_mm,
        ahead.feature,
        *failed.found_again_mm);
  }
  return fmt::format(
      "nothing was met up to {:.1f} mm behind where {} is entered{}: the artefact "
      "stands elsewhere, or the probe does not trigger. Push the stylus by hand: "
      "sensors.probes[0].value must turn to 1000",
      ahead.beyond_mm,
      ahead.feature,
      failed.was_tried_again ? ", nor after homing, so no steps were lost" : "");
}

// Sums of squares about the mean of each face.
struct Spread {
  double squares_mm2 = 0;
  int dof = 0;
};

double Mean_mm(std::span<const double> touches_mm) {
  double sum_mm = 0;
  for (const double mm : touches_mm) sum_mm += mm;
  return touches_mm.empty() ? 0 : sum_mm / static_cast<double>(touches_mm.size());
}

double Squares_mm2(std::span<const double> touches_mm) {
  const double mean_mm = Mean_mm(touches_mm);
  double squares_mm2 = 0;
  for (const double mm : touches_mm) squares_mm2 += (mm - mean_mm) * (mm - mean_mm);
  return squares_mm2;
}

Spread SpreadOf(std::span<const std::vector<double>> faces_mm) {
  Spread spread;
  for (const std::vector<double>& face_mm : faces_mm) {
    spread.squares_mm2 += Squares_mm2(face_mm);
    spread.dof += std::max(static_cast<int>(face_mm.size()) - 1, 0);
  }
  return spread;
}

constexpr double kExplains = 9;  // Of the squares: what is left is a third as wide.
constexpr int kFewestLeft = 6;   // Degrees of freedom, else chance does it.

// Whether what one figure leaves of the squares is little, and enough touches are left.
bool Explains(double left_mm2, const Spread& spread) {
  return spread.dof - 1 >= kFewestLeft && left_mm2 * kExplains <= spread.squares_mm2;
}

// The step between two touches of one face that leaves the least.
std::string TwoLevels(std::span<const std::vector<double>> faces_mm,
                      const Spread& spread) {
  double least_mm2 = spread.squares_mm2;
  double step_mm = 0;
  std::size_t after = 0;
  for (const std::vector<double>& face_mm : faces_mm) {
    const std::span<const double> all_mm(face_mm);
    for (std::size_t i = 2; i + 2 <= face_mm.size(); ++i) {
      const auto first_mm = all_mm.first(i), rest_mm = all_mm.subspan(i);
      const double left_mm2 = spread.squares_mm2 - Squares_mm2(all_mm) +
                              Squares_mm2(first_mm) + Squares_mm2(rest_mm);
      if (left_mm2 >= least_mm2) continue;
      least_mm2 = left_mm2;
      step_mm = Mean_mm(rest_mm) - Mean_mm(first_mm);
      after = i;
    }
  }
  if (!Explains(least_mm2, spread)) return "";
  return fmt::format(
      "two levels, {:.3f} mm apart: from touch {} on all lie there, and each level "
      "scatters by {:.1f} um only. Something moved once in between: the block was "
      "pushed, or the axis lost steps; the probe repeats. Home and touch again: a "
      "level that comes back was lost steps",
      std::abs(step_mm),
      after + 1,
      UmFromMm(std::sqrt(least_mm2 / (spread.dof - 1))));
}

std::string OneBadTouch(std::span<const std::vector<double>> faces_mm,
                        const Spread& spread) {
  double least_mm2 = spread.squares_mm2;
  double off_mm = 0;
  std::size_t worst = 0;
  for (const std::vector<double>& face_mm : faces_mm) {
    for (std::size_t i = 0; i < face_mm.size() && face_mm.size() > 2; ++i) {
      std::vector<double> rest_mm = face_mm;
      rest_mm.erase(rest_mm.begin() + static_cast<std::ptrdiff_t>(i));
      const double left_mm2 =
          spread.squares_mm2 - Squares_mm2(face_mm) + Squares_mm2(rest_mm);
      if (left_mm2 >= least_mm2) continue;
      least_mm2 = left_mm2;
      off_mm = face_mm[i] - Mean_mm(rest_mm);
      worst = i;
    }
  }
  if (!Explains(least_mm2, spread)) return "";
  return fmt::format(
      "one touch, the {}. of its face, lies {:+.3f} mm off all others, which scatter "
      "by "
      "{:.1f} um: a chip, or the switch bounced; clean ball and face and touch again",
      worst + 1,
      off_mm,
      UmFromMm(std::sqrt(least_mm2 / (spread.dof - 1))));
}

// A line over the number of the touch, of each face its own.
std::string Drift(std::span<const std::vector<double>> faces_mm, const Spread& spread) {
  constexpr double kShare = 0.75;
  double taken_mm2 = 0;
  double per_touch_mm = 0;
  int lines = 0;
  for (const std::vector<double>& face_mm : faces_mm) {
    const auto count = static_cast<double>(face_mm.size());
    if (count < 3) continue;
    double product = 0, squares = 0;
    for (std::size_t i = 0; i < face_mm.size(); ++i) {
      const double number = static_cast<double>(i) - (count - 1) / 2;
      product += number * face_mm[i];
      squares += number * number;
    }
    taken_mm2 += product * product / squares;
    if (std::abs(product / squares) > std::abs(per_touch_mm)) {
      per_touch_mm = product / squares;
    }
    ++lines;
  }
  if (spread.dof - lines < kFewestLeft || taken_mm2 < kShare * spread.squares_mm2) {
    return "";
  }
  return fmt::format(
      "they drift: {:+.2f} um from touch to touch, which is {:.0f} % of their scatter. "
      "Something warms, creeps or winds itself loose while it is touched; the probe "
      "repeats. Let the machine come to rest and touch again",
      UmFromMm(per_touch_mm),
      PercentFromFraction(taken_mm2 / spread.squares_mm2));
}

}  // namespace

std::string WhyProbeFailed(const FailedProbeMove& failed) {
  using End = FailedProbeMove::End;
  if (failed.after == ProbeReading::kMissing) {
    return "the firmware has no probe configured (sensors.probes is empty): set it up "
           "by M558, and check its number (K) in the macro";
  }
  if (failed.end == End::kBent) {
    if (failed.after != ProbeReading::kFree) return "";
    return "the stylus is bent beyond its overtravel and the firmware still reads the "
           "probe as free: its signal does not arrive. Look at cable, battery and pin "
           "(M558 C) before anything moves again";
  }
  if (failed.end == End::kTriggeredBefore) {
    if (failed.after == ProbeReading::kTriggered) {
      return "the probe reads triggered with the stylus lifted clear of everything: "
             "its wire is shorted, its pin inverted (M558 C), or the stylus not seated";
    }
    if (failed.after == ProbeReading::kUnknown) return "";
    return "the probe reads free once it is lifted: the move began in contact. Start "
           "it "
           "further off the surface";
  }
  return failed.after == ProbeReading::kFree ? WhyNothingMet(failed) : "";
}

std::string WhyInconsistent(std::span<const std::vector<double>> faces_mm) {
  const Spread spread = SpreadOf(faces_mm);
  if (spread.dof < 1) return "";
  for (const auto why : {OneBadTouch, TwoLevels, Drift}) {
    const std::string words = why(faces_mm, spread);
    if (!words.empty()) return words;
  }
  if (spread.dof < kFewestLeft) return "";
  return fmt::format(
      "{} touches of {} scatter by {:.1f} um in no order, without drift, level or one "
      "that stands apart: the probe does not repeat (dirt on ball or face, a loose "
      "stylus or holder), and nothing has moved meanwhile",
      spread.dof + static_cast<int>(faces_mm.size()),
      faces_mm.size() == 1 ? "one face" : fmt::format("{} faces", faces_mm.size()),
      UmFromMm(std::sqrt(spread.squares_mm2 / spread.dof)));
}

std::string WhyUnlikelySteps(double ratio) {
  constexpr double kWithin = 0.005;
  constexpr double kInch_mm = 25.4;
  const auto is = [&](double times) {
    return std::abs(ratio / times - 1) < kWithin ||
           std::abs(ratio * times - 1) < kWithin;
  };
  // What is built, what is entered: steps/mm grow as the built one is smaller.
  struct Part {
    int less, more;
  };
  constexpr std::array kLeads_mm = {
      Part{1, 10}, Part{1, 5}, Part{2, 5}, Part{4, 5}, Part{5, 8}, Part{1, 8}};
  std::string cause;
  if (is(kInch_mm)) cause = "inches for millimetres make";
  if (is(2) || is(4)) cause = "a setting of the driver's microsteps makes";
  for (const Part& lead : kLeads_mm) {
    if (!is(static_cast<double>(lead.more) / lead.less)) continue;
    const int built = ratio > 1 ? lead.less : lead.more;
    const int entered = ratio > 1 ? lead.more : lead.less;
    cause = fmt::format(
        "a lead of {} mm where {} is entered (or a pulley of {} teeth for {}) makes",
        built,
        entered,
        4 * built,
        4 * entered);
  }
  if (cause.empty()) return "";
  return fmt::format(
      "{:.4f} times what is set, as {}: another part or setting, no calibration that "
      "drifted. Enter it by hand, then calibrate",
      ratio,
      cause);
}

bool IsUnlikely(const UnlikelyPretravel& pretravel, double sd_mm) {
  constexpr double kTimesDrawn = 10;
  const double least_mm = -kSure * sd_mm;
  const double most_mm = kTimesDrawn * pretravel.drawn_mm + kSure * sd_mm;
  return pretravel.found_mm < least_mm || pretravel.found_mm > most_mm;
}

std::string WhyUnlikelyPretravel(const UnlikelyPretravel& p) {
  const double drawn_off_mm = p.found_mm - p.drawn_mm;
  if (p.calliper_size_mm) {
    // The block reads small by its own error, which counts half on each face.
    const double too_large_mm = p.entered_size_mm - *p.calliper_size_mm;
    const double left_mm = drawn_off_mm - too_large_mm / 2;
    if (std::abs(left_mm) < std::abs(drawn_off_mm) / 10) {
      return fmt::format(
          "the artefact is not {:.3f} mm as entered: a calliper reads {:.3f}, and half "
          "of the difference is what the pre-travel of {:.3f} mm is off. Enter its "
          "size",
          p.entered_size_mm,
          *p.calliper_size_mm,
          p.found_mm);
    }
  }
  // An entered radius too large by R reads as so much pre-travel.
  const double likely_mm = p.entered_radius_mm / 2;
  if (std::abs(drawn_off_mm - likely_mm) < likely_mm / 10) {
    return fmt::format(
        "a pre-travel of {:.3f} mm is half the entered tip radius of {:.3f} mm and "
        "what "
        "is drawn ({:.3f}): the ball's diameter was entered as its radius",
        p.found_mm,
        p.entered_radius_mm,
        p.drawn_mm);
  }
  if (std::abs(drawn_off_mm + p.entered_radius_mm) < p.entered_radius_mm / 10) {
    return fmt::format(
        "a pre-travel of {:.3f} mm is less than nothing by the entered tip radius of "
        "{:.3f} mm: half the ball's radius was entered",
        p.found_mm,
        p.entered_radius_mm);
  }
  return "";
}

std::string WhyWorse(double before, double after, double sd) {
  const double magnitude = std::abs(before);
  const bool was_right = magnitude < kSure * sd;
  if (was_right) {
    return fmt::format(
        "before the change the error was {:+.4f}, nothing beyond chance, and now it is "
        "{:+.4f}: what was corrected was right already, or is compensated elsewhere",
        before,
        after);
  }
  constexpr double kNear = 0.2;
  const double ratio = after / before;
  if (std::abs(ratio - 2) < kNear) {
    return fmt::format(
        "the error went from {:+.4f} to {:+.4f}, {:.2f} times: the correction has the "
        "wrong sign (or its ratio is upside down), for the machine followed it in full",
        before,
        after,
        ratio);
  }
  return "";
}

std::string WhyTooMuchCompensation(double set_mm, double left_mm) {
  if (left_mm >= 0 || set_mm <= 0) return "";
  const double gap_mm = set_mm + left_mm;
  constexpr double kNear = 0.1;
  if (std::abs(gap_mm / set_mm - 0.5) < kNear) {
    return fmt::format(
        "{:.4f} mm are compensated and the gap is {:.4f}, half of it: the play was "
        "counted twice (measured with compensation on, and added)",
        set_mm,
        gap_mm);
  }
  return fmt::format(
      "{:.4f} mm are compensated, more than the gap of {:.4f}", set_mm, gap_mm);
}

}  // namespace caltwin
