#pragma once

#include <string>

#include "calibration/loop/session.h"
#include "calibration/procedures/catalog.h"

namespace caltwin {

struct DiagonalOptions {
  bool as_published = false;  ///< Each axis by itself.
  int positions = 7;          ///< On each diagonal.
  int repeats = 2;            ///< There and back.
  bool verify = true;
  std::string instrument = "laser";
  LoopRules rules{};
};

/// Moves each belt of a CoreXY alone, along its diagonal, and reads how far the head
/// goes along x and y, from both senses:
///
///   read = o + (1 + e) told - dir g / 2,   read = x + y of belt A, x - y of belt B
///
/// e gives that belt's steps/mm, s / (1 + e), and g the play that is left of it [mm].
/// What makes one diagonal longer than the other may be a belt or a beam that is not
/// square (racking): this cannot tell them apart, and says so.
Expected<void> RunDiagonals(Session* session, const DiagonalOptions& options);

extern const Procedure kBeltDiagonals;

}  // namespace caltwin
