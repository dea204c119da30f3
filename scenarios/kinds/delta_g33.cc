#include "scenarios/kinds/delta_g33.h"

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

G33Program MarlinG33(G33Variant variant, double print_radius_mm) {
  return [variant, print_radius_mm](const GcodeCommand& words,
                                    const DeltaModel<double>& settings,
                                    const Vec3<double>& probe_offset_mm,
                                    const TouchOfBed& touch) {
    G33Options options{.probe_offset_mm = probe_offset_mm, .variant = variant};
    options.printable_radius_mm = print_radius_mm;
    options = ReadG33(words, options);
    DeltaOutcome outcome = CalibrateG33(touch, settings, options);
    return G33Answer{.settings = outcome.settings,
                     .lines = std::move(outcome.messages),
                     .said_mm = outcome.said_mm,
                     .stows = options.engages_probe};
  };
}

DeltaCalliper CalliperOf(DeltaTwin* twin) {
  return {.rod_mm = [twin](int rod) { return twin->calliper().Rod_mm(rod); },
          .between_mm =
              [twin](const Vec3<double>& from_mm, const Vec3<double>& to_mm) {
                return twin->calliper().Between_mm(from_mm, to_mm);
              },
          .sigma_mm = twin->config().calliper_sigma_mm};
}

}  // namespace caltwin
