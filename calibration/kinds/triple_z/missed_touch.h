#pragma once

#include <span>
#include <string>

#include "calibration/kinds/triple_z/printer.h"
#include "calibration/loop/probe_reading.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// A touch of the bed that gave no height, where the published trouble list says
/// "check G31, verify the trigger distance".
struct MissedTouch {
  std::string reply{};  ///< The machine's words.
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  /// Of the probe afterwards, the bed as far down as it was homed.
  ProbeReading clear = ProbeReading::kUnknown;
  std::span<const BedTouch> before{};  ///< Touches of the same round that gave heights.
};

/// Why, as one sentence: no probe, a probe that always or never reads triggered, or a
/// bed that stands outside the reach of a touch there; how it is known, and what to do.
/// Where nothing tells, what would.
std::string WhyNoHeight(const MissedTouch& missed);

/// Lowers the bed, asks for the probe and says it. A link that is lost says nothing.
std::string AskWhyNoHeight(TripleZPrinter* printer,
                           const Eigen::Vector2d& at_mm,
                           std::span<const BedTouch> before,
                           const MachineFault& fault);

}  // namespace caltwin
