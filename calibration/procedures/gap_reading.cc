#include "calibration/procedures/gap_reading.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calibration/estimate/backlash.h"
#include "calibration/estimate/expanded.h"
#include "sim/base/units.h"

namespace caltwin {

Expected<Uncertain> ReadGapLeft(Session* session,
                                Axis axis,
                                const std::string& instrument,
                                int repeats) {
  const AxisDrawing& drawing = session->bench().machine.axis(axis);
  const double lead_mm = session->probing().LeadIn_mm(Unit(axis)) + 5;
  if (const auto raised = session->probing().Raise(); !raised) {
    return tl::unexpected(raised.error());
  }
  Vec3<double> at_mm = session->controller().position_mm();
  // Along z it all happens above the artefacts.
  const double high_mm = drawing.max_mm - 2 * lead_mm - 1;
  at_mm[Index(axis)] = axis == Axis::kZ ? high_mm : drawing.mid_mm();
  const auto go = [&](double by_mm) {
    Vec3<double> target_mm = at_mm;
    target_mm[Index(axis)] += by_mm;
    return session->controller().MoveTo(target_mm, drawing.max_feed_mm_s / 4);
  };
  std::vector<double> readings_mm;
  for (int i = 0; i < repeats; ++i) {
    const double back_mm = -lead_mm;
    for (const double by_mm : {back_mm, 0.0}) {
      if (const auto gone = go(by_mm); !gone) return tl::unexpected(gone.error());
    }
    const auto zero = session->bench().gauge->Read_mm(instrument);
    if (!zero) return tl::unexpected(zero.error());
    for (const double by_mm : {lead_mm, 0.0}) {
      if (const auto gone = go(by_mm); !gone) return tl::unexpected(gone.error());
    }
    const auto reading = session->bench().gauge->Read_mm(instrument);
    if (!reading) return tl::unexpected(reading.error());
    readings_mm.push_back(*reading - *zero);
  }
  const std::string kind = instrument.substr(0, instrument.find('.'));
  double sd_mm = 0;
  if (const auto found = session->bench().instruments.find(kind);
      found != session->bench().instruments.end()) {
    sd_mm = std::hypot(MmFromUm(found->second.sigma_um),
                       MmFromUm(found->second.resolution_um) / std::sqrt(12.0));
  }
  std::vector<double> each_mm;  // Of one reading; zeroing is another.
  for (const double reading_mm : readings_mm) {
    each_mm.push_back(reading_mm / std::numbers::sqrt2);
  }
  const std::span<const double> group_mm(each_mm);
  const TouchNoise seen = NoiseSeen({.sigma_mm = sd_mm}, std::span(&group_mm, 1));
  Uncertain left_mm = BacklashFromDial(readings_mm, +1, seen.sigma_mm);
  left_mm.budget = {InputOf("readings", 1, {.sd = left_mm.sd, .dof = seen.dof})};
  // Both approaches stop at the same count, but for what is compensated: that is
  // rounded to whole steps, in each sense by itself and in every repeat alike.
  if (session->Believed(Setting::kBacklash, axis) != 0) {
    const double step_mm = session->probing().Noise(axis).step_mm;
    left_mm = WithInput(std::move(left_mm),
                        {.input = "whole steps of the compensation",
                         .u = step_mm * std::sqrt(2 / 12.0)});
  }
  return left_mm;
}

}  // namespace caltwin
