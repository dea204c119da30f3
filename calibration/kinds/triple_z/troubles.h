#pragma once

#include <optional>
#include <span>
#include <string>

#include "calibration/kinds/triple_z/plane.h"
#include "calibration/kinds/triple_z/printer.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// Why touches do not lie on their plane, where the published trouble list says "more
/// points, debris, or the probe".
struct OffPlane {
  enum class Cause {
    kOneTouch,  ///< All others agree: something lies there, or the touch was bad.
    kBent,      ///< A smooth shape: no screw takes it out.
    kScatter,   ///< No shape: the touches do not repeat.
    kFew        ///< Too few touches to tell the others apart.
  };
  Cause cause = Cause::kScatter;
  std::size_t touch = 0;  ///< Of kOneTouch.
  double size_mm = 0;     ///< How far it sticks out; peak to peak of a shape; rms.
  std::string found{};    ///< What the touches show, half a sentence.
  std::string advice{};   ///< The other half: what that may be, and what to do.

  std::string words() const { return found + ": " + advice; }
};

/// The published list, where a residual is above its 0.2 mm; else empty.
std::string HighResidualAsPublished(const BedPlane& plane);

/// What one touch may be off by before anybody asks why: as stated, else 0.02 mm.
double Unsuspected_mm(const TripleZBench& bench);

/// nullopt where the touches lie on the plane as well as they repeat. Fewer than six
/// leave too little to tell by. A touch sticks out where the rest is three
/// times as flat without it; a bed is bent where a quadratic shape takes three quarters
/// of the squares, beyond what chance does (F, 99 %).
/// @param sigma_mm  standard uncertainty of one touch
std::optional<OffPlane> WhyOffPlane(std::span<const BedTouch> touches, double sigma_mm);

/// Touches the place again that WhyOffPlane doubts, and says what it then is: debris
/// that is still there, a bad touch, a probe that does not repeat, a rough bed. A touch
/// that fails, or nothing to doubt: as WhyOffPlane has it.
std::string TouchAgain(TripleZPrinter* printer,
                       const OffPlane& off,
                       std::span<const BedTouch> touches);
/// The sentence of TouchAgain, by the heights it read.
std::string WordsOfAgain(const OffPlane& off,
                         double first_mm,
                         std::span<const double> again_mm);

/// What screws did that were to be raised by `applied_mm` and moved the bed over them
/// by `moved_mm`, where that is something else: it stayed, went the other way, some
/// stand still, their drivers are exchanged, or the tilt follows in part, so that
/// another round takes the rest. Empty where it did as told, or nothing fits.
/// @param noise_mm  standard uncertainty of `moved_mm`
std::string WhyNotLevel(const Vec3<double>& applied_mm,
                        const Vec3<double>& moved_mm,
                        double noise_mm);
/// The same by the planes touched before and after; noise is what they scatter by, or
/// `sigma_mm`.
std::string WhyNotLevel(const Vec3<double>& applied_mm,
                        const BedPlane& before,
                        const BedPlane& after,
                        const TripleZBench& bench);

}  // namespace caltwin
