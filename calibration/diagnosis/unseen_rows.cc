#include "calibration/diagnosis/unseen_rows.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kWorse = 1.005;  // More than rounding.

bool IsWorse(const HeldOut& held) {
  return held.groups > 0 && held.after_mm > kWorse * held.before_mm;
}

std::string Figures(const HeldOut& held) {
  return fmt::format("{} um rms without what was found, {} with it",
                     TwoDigits(UmFromMm(held.before_mm)),
                     TwoDigits(UmFromMm(held.after_mm)));
}

UnseenRows Against(std::string_view where, const HeldOut& held) {
  return {.worse = fmt::format("Do not correct by it: {} it makes rows worse that it "
                               "has not seen ({}).",
                               where,
                               Figures(held)),
          .is_recommended = false};
}

// It may be asked for what lies between its places.
bool IsOfPlaces(const Finding& finding) {
  return std::ranges::any_of(finding.covariates, [](const std::string& word) {
    return word == "x" || word == "y" || word == "z";
  });
}

}  // namespace

UnseenRows WhatUnseenRowsSay(const Finding& finding, const GainFigures& gain) {
  if (!finding.map) return {};
  if (IsWorse(gain.blocks)) return Against("at other times", gain.blocks);
  if (IsWorse(gain.runs)) return Against("in other runs", gain.runs);
  if (!IsOfPlaces(finding)) return {};
  if (IsWorse(gain.positions)) {
    return Against("between the positions measured", gain.positions);
  }
  if (!IsWorse(gain.ends)) return {};
  return {.worse = fmt::format("It holds between the first and the last position "
                               "measured only: beyond them it makes rows worse that it "
                               "has not seen ({}).",
                               Figures(gain.ends))};
}

}  // namespace caltwin
