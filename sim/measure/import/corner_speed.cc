#include "sim/measure/import/corner_speed.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {

void CornerSpeed::Take(const ConsoleLine& line) {
  // Before 0.9 it was $9, and $11 something else.
  const bool is_named = line.lower.find("junction") != std::string::npos;
  const bool is_other = line.lower.find('(') != std::string::npos && !is_named;
  is_old_ |= is_named && GrblSetting(line, 9).has_value();
  if (!is_other) deviation_mm_ = GrblSetting(line, 11).value_or(deviation_mm_);
  acceleration_mm_s2_ = GrblSetting(line, 120).value_or(acceleration_mm_s2_);
  most_mm_min_ = GrblSetting(line, 110).value_or(most_mm_min_);
}

void CornerSpeed::Tell(Imported* imported) const {
  constexpr double kMost_mm = 1, kUsual_mm = 0.01;
  constexpr double kSine = 1 / std::numbers::sqrt2;
  if (is_old_ || !(deviation_mm_ > kMost_mm)) return;
  std::string speed;
  if (acceleration_mm_s2_ > 0) {
    const auto speed_mm_min = [&](double deviation_mm) {
      return 60 * std::sqrt(acceleration_mm_s2_ * deviation_mm * kSine / (1 - kSine));
    };
    speed = fmt::format(
        ": a right angle is taken at up to {:.0f} mm/min ({} with $11={:g}){}",
        speed_mm_min(deviation_mm_),
        TwoDigits(speed_mm_min(kUsual_mm)),
        kUsual_mm,
        speed_mm_min(deviation_mm_) > 0.9 * most_mm_min_
            ? ", as fast as the axis can be, so it never slows"
            : "");
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "$11={:g} is a junction deviation of {:g} mm, where some hundredths are "
           "usual{}. The axis that ends its move stops dead, and steps are lost there. "
           "Set $11={:g}; steps/mm and mechanics are not shown to be wrong",
           deviation_mm_,
           deviation_mm_,
           speed,
           kUsual_mm),
       .fact = "settings",
       .word = "$11",
       .figures = {{"junction_deviation_um", UmFromMm(deviation_mm_)}}});
}

}  // namespace caltwin
