#pragma once

#include <cstdint>
#include <optional>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// Where the tool stands at poses that nobody measured: how far from where the machine
/// is believed to, before and after what was found is corrected. Distances in space,
/// rms over poses drawn evenly in the travel, each axis coming in either sense; the
/// mean of all poses, which a work offset takes, is not counted.
struct VolumetricGain {
  int poses = 0;
  /// Findings and fitted baseline against the machine as believed.
  double before_mm = 0;
  /// What their standard deviations leave open; correlations are neglected.
  double after_mm = 0;
  /// What the findings move alone, beside the baseline: rms and largest.
  double findings_mm = 0, findings_max_mm = 0;
};

/// Of findings that are motion errors; none where there are none. Of the baseline those
/// lines count, in both figures, that differ from what is believed by more than two
/// standard deviations: the others would not be changed. Circumstances (time,
/// temperature, load, feed) are those of rows drawn by chance.
std::optional<VolumetricGain> VolumetricGainOf(const Observed& observed,
                                               const Diagnosis& diagnosis,
                                               std::uint64_t seed);

/// `"volumetric"` of `gain`; null where there is none.
nlohmann::ordered_json VolumetricJson(const std::optional<VolumetricGain>& gain);

/// One sentence; empty where there is none.
std::string VolumetricText(const std::optional<VolumetricGain>& gain);

}  // namespace caltwin
