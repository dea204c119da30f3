#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/changes.h"
#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/would_show.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a text needs beside the diagnosis.
struct TextNotes {
  std::string measured = "the rows";    ///< WhatRowsMeasure.
  std::vector<WouldShow> would_show{};  ///< Told where nothing was found.
  std::vector<Change> changes{};        ///< Since an earlier campaign.
  bool has_before = false;              ///< There was one.
};

/// "X" where every row is measured along that axis, else "the rows".
std::string WhatRowsMeasure(const RowTable& table);

/// One finding in two sentences: what it does, its share and how sure it is; what
/// correcting it is worth. The rms after correcting one finding alone follows from its
/// share s of the explainable variance: sqrt(before^2 - s (before^2 - floor^2)).
std::string FindingText(const Finding& finding,
                        const Diagnosis& diagnosis,
                        const std::string& measured);

/// The whole answer as a machinist reads it: findings, rivals, what cannot be told and
/// which measurement would, baseline, rows left out, wander, remarks. One paragraph a
/// line.
std::string DiagnosisText(const Diagnosis& diagnosis, const TextNotes& notes);

}  // namespace caltwin
