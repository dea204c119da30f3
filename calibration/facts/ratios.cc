#include "calibration/facts/ratios.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/facts/fact.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kCalibration = 0.12;  // Nearer to 1: drives differ by that.
constexpr double kNear = 0.015;

bool IsNear(double factor, double what, double sd) {
  constexpr double kSure = 3, kMost = 0.06;
  const double tolerance =
      Known(sd) ? std::clamp(kSure * sd / what, kNear, kMost) : 2 * kNear;
  return std::abs(factor / what - 1) < tolerance;
}

// "16" of 16, "1/16" of 0.0625.
std::string Ratio(double factor) {
  return factor >= 1 ? fmt::format("{:.4g}", factor)
                     : fmt::format("1/{:.4g}", 1 / factor);
}

// Ratios of screws' leads and pulleys' teeth that are often taken for each other.
struct Mixed {
  double ratio = 1;
  const char* what = nullptr;
};
constexpr std::array kMixed = {
    Mixed{1.25, "pulleys of 20 and 16 teeth, or screws of 5 and 4 mm lead"},
    Mixed{1.6, "screws of 8 and 5 mm lead"},
    Mixed{2.5, "screws of 5 and 2 mm lead"},
    Mixed{1.5, "screws of 12 and 8, or 3 and 2 mm lead"},
    Mixed{3, "a gear of 3 : 1"},
    Mixed{5, "screws of 10 and 2 mm lead, or a gear of 5 : 1"},
    Mixed{1.27, "screws of 5.08 mm (five threads an inch) and 4 mm lead"}};

// An inch, a tenth of one, or a thousand; empty reading: none of them.
KnownRatio OfInches(double factor, double sd, const std::string& mend) {
  const double inverse = 1 / factor;
  if (IsNear(factor, MmFromInch(1.0), sd) || IsNear(inverse, MmFromInch(1.0), sd)) {
    return {.reading = "inches",
            .sentence =
                "25.4: one of the two, command or reading, is in inches (G20 and "
                "G21, or the display of the gauge)"};
  }
  constexpr double kTenthOfInch = 10;
  const double in_tenths = MmFromInch(1.0) / kTenthOfInch;
  if (IsNear(factor, in_tenths, sd) || IsNear(inverse, in_tenths, sd)) {
    constexpr double kLead = 2.5, kExact = 0.005;
    const double larger = std::max(factor, inverse);
    const bool has_rival =
        IsNear(larger, kLead, sd) && std::abs(larger / in_tenths - 1) > kExact;
    if (has_rival) {
      return {
          .reading = "inches",
          .also = {"lead"},
          .has_rival = true,
          .sentence = fmt::format(
              "2.5 is what a screw of another lead does (5 and 2 mm), 2.54 what "
              "inches and centimetres do that were taken for each other; this "
              "measurement does not part them. Jog 100 mm by hand: if that is right, "
              "the file is at fault; else {}",
              mend)};
    }
    return {.reading = "inches",
            .also = {"lead"},
            .sentence =
                fmt::format("2.54 is a tenth of an inch: steps/mm were reckoned for "
                            "inches or tenths of "
                            "them, or a screw in inches was taken for one in mm; {}",
                            mend)};
  }
  if (IsNear(factor, UmFromMm(1.0), sd) || IsNear(inverse, UmFromMm(1.0), sd)) {
    return {
        .reading = "unit",
        .sentence = "1000: one of the two is in micrometres, the other in millimetres"};
  }
  return {};
}

// A power of two.
KnownRatio OfPower(double factor, double sd, const std::string& mend) {
  const double power = std::round(std::log2(factor));
  if (power != 0 && std::abs(power) <= 8 && IsNear(factor, std::exp2(power), sd)) {
    KnownRatio known{
        .reading = "microsteps",
        .also = {"gear"},
        .sentence = fmt::format(
            "a power of two: the microsteps that the driver is set to (jumpers, "
            "M350, microsteps) are not those that steps/mm were reckoned with; "
            "set them alike, or {}",
            mend)};
    if (std::abs(power) == 1) {
      known.also = {"diameter_radius", "lead", "gear", "full_steps"};
      known.sentence = fmt::format(
          "2 is what wrong microsteps, motors of 0.9 in place of 1.8 degrees, a screw "
          "of "
          "twice the lead, or a diameter taken for a radius do: look which it is; {}",
          mend);
    }
    if (std::abs(power) == 2) known.also = {"lead", "gear"};
    return known;
  }
  return {};
}

constexpr std::array kFine = {
    FineRatio{1000.0 / 1024,
              "encoder_lines",
              "It is 1000 / 1024: an encoder of 1000 lines taken for one of 1024 (4000 "
              "and 4096 counts) does just that, before any screw is to blame"},
    FineRatio{96.0 / 90,
              "pixels_per_inch",
              "It is 96 / 90, the pixels an inch of two programs that draw: if these "
              "are sizes of a drawing, set them alike there and leave steps/mm alone"}};

}  // namespace

FineRatio FineRatioOf(double factor, double sd) {
  constexpr double kExact = 5e-4;
  if (Known(sd) && sd > kExact) return {};
  for (const FineRatio& fine : kFine) {
    for (const double ratio : {fine.ratio, 1 / fine.ratio}) {
      if (std::abs(factor / ratio - 1) < kExact) return fine;
    }
  }
  return {};
}

KnownRatio KnownRatioOf(double factor, double sd) {
  if (std::abs(factor - 1) < kCalibration || factor == 0) return {};
  if (factor < 0) {
    if (!IsNear(-factor, 1, sd)) return {};
    return {.reading = "sign",
            .sentence =
                "it moves the other way: the direction of the motor, or the sign "
                "of the readings, is reversed"};
  }
  const double inverse = 1 / factor;
  const std::string mend =
      fmt::format("steps/mm are to be multiplied by {}", Ratio(inverse));
  if (KnownRatio inches = OfInches(factor, sd, mend); !inches.reading.empty())
    return inches;
  if (KnownRatio power = OfPower(factor, sd, mend); !power.reading.empty())
    return power;
  for (const Mixed& mixed : kMixed) {
    if (!IsNear(factor, mixed.ratio, sd) && !IsNear(inverse, mixed.ratio, sd)) continue;
    return {.reading = "lead",
            .also = {"gear", "pulley"},
            .sentence = fmt::format(
                "that is {}, one taken for the other; {}", mixed.what, mend)};
  }
  return {};
}

}  // namespace caltwin
