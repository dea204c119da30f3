#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// The measured rows taken again by MuJoCo: what the twin of the machine as believed
/// with its baseline as fitted reads, and what it reads once the findings act in it.
/// Rows that the diagnosis left out do not count [mm rms].
struct Replay {
  /// Why there is none, a sentence; empty: there is one.
  std::string why_not{};
  bool is_generic_model = false;  ///< The machine file names no model of its own.
  bool has_findings = false;
  double before_mm = 0;  ///< Baseline as well as it can be fitted alone.
  double after_mm = 0;   ///< The findings act in the twin.
  /// Reading in MuJoCo less that of the closed form, the findings acting in both.
  double form_rms_mm = 0, form_max_mm = 0;
  double floor_mm = 0;  ///< The diagnosis' noise floor.
  int rows = 0;
  /// Rows whose difference from the closed form exceeds half of their noise.
  std::vector<std::int64_t> far_rows{};
  /// Findings that no twin can be built with; they are taken as fitted.
  std::vector<std::string> as_fitted{};
  /// Lines of the baseline that the rows do not determine: the twin has them as drawn.
  std::vector<std::string> as_drawn{};
  Eigen::VectorXd left_before_mm{}, left_after_mm{};  ///< Of every row, for pictures.
};

struct ReplayOptions {
  int most_rows = 3000;
  /// Asked before each row; true ends it.
  std::function<bool()> interrupted{};
};

/// Replays the rows. The baseline is fitted beside the findings as they are stated, and
/// once more without them, since it then takes other values; each goes into a twin of
/// its own. What cannot be built into a machine (where artefacts lie, the zeros of
/// gauges, sizes within their certificates, each homing's place) is then fitted to what
/// that twin leaves. The freedom of form that a finding was granted is not: what it
/// took shows in the rest.
Replay ReplayOf(const Observed& observed,
                const Diagnosis& diagnosis,
                const ReplayOptions& options);

/// One sentence, and one for each thing a person should know of it.
std::string ReplayText(const Replay& replay);

/// `"replay"` of `diagnose --json`; null where there is none.
nlohmann::ordered_json ReplayJson(const Replay& replay);

}  // namespace caltwin
