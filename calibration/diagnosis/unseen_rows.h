#pragma once

#include <string>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// What rows that a table has not seen say of correcting by it. Of a finding with a
/// name nothing: what is to be done about a cause does not follow from what it
/// foretells.
struct UnseenRows {
  /// Where it makes them worse, as a sentence; empty: nowhere that was tried.
  std::string worse{};
  /// False where they speak against correcting by it at all: at other times, in other
  /// runs, or, of a table of places, between its positions. Beyond its first and last
  /// position it need not hold to be of use.
  bool is_recommended = true;
};
UnseenRows WhatUnseenRowsSay(const Finding& finding, const GainFigures& gain);

}  // namespace caltwin
