#pragma once

#include <optional>
#include <span>
#include <string>

#include "calibration/kinds/triple_z/plane.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// Why touches do not lie on their plane, where the published trouble list says "more
/// points, debris, or the probe".
struct OffPlane {
  enum class Cause {
    kOneTouch,  ///< All others agree: something lies there, or the touch was bad.
    kBent,      ///< A smooth shape: no screw takes it out.
    kScatter    ///< No shape: the touches do not repeat.
  };
  Cause cause = Cause::kScatter;
  std::size_t touch = 0;  ///< Of kOneTouch.
  double size_mm = 0;     ///< How far it sticks out; peak to peak of a shape; rms.
  std::string words{};    ///< One sentence.
};

/// nullopt where the touches lie on the plane as well as they repeat, or where fewer
/// than six leave too little to tell by. A touch sticks out where the rest is three
/// times as flat without it; a bed is bent where a quadratic shape takes three quarters
/// of the squares, beyond what chance does (F, 99 %).
/// @param sigma_mm  standard uncertainty of one touch
std::optional<OffPlane> WhyOffPlane(std::span<const BedTouch> touches, double sigma_mm);

/// What screws did that were to be raised by `applied_mm` and moved the bed over them
/// by `moved_mm`, where that is something else: it stayed, went the other way, some
/// stand still, or their drivers are exchanged. Empty where it did as told, or nothing
/// fits.
/// @param noise_mm  standard uncertainty of `moved_mm`
std::string WhyNotLevel(const Vec3<double>& applied_mm,
                        const Vec3<double>& moved_mm,
                        double noise_mm);

}  // namespace caltwin
