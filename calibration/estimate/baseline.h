#pragma once

#include <string>
#include <vector>

#include "calibration/estimate/joint.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What the baseline holds beside the offsets, which are always free.
struct BaselineOptions {
  bool scale = true;
  bool reversal = true;
  /// The machine the rows came from; none: each axis as a plain one with home at 0.
  const Machine* machine = nullptr;
  SettingsById settings{};
};

/// One line of a baseline: "scale.x" in ppm, "backlash.x", "probe_pretravel.x" and
/// "placement.CAMPAIGN.x" in mm.
struct BaselineValue {
  std::string name{};
  std::string unit{};
  double value = 0;
  double sd = 0;
  bool identifiable = false;
};

/// The plainest model of measured rows: what every axis has.
struct BaselineFit {
  std::vector<BaselineValue> values{};
  std::vector<double> residuals_mm{};  ///< By row.
  double rms_mm = 0;
  double dof = 0;
  /// sds were multiplied by this, from the residuals' own size: the rows stated no
  /// sigma, or scatter more than they stated.
  double sd_factor = 1;
  bool converged = false;
  ObservabilityReport observability{};

  const BaselineValue* Find(std::string_view name) const;
};

/// Least squares of offset (one a campaign and setup), scale and reversal on every axis
/// the rows measure, through the joint estimate without beliefs; touches add the
/// pre-travel, with the declared ones.
///
/// `scale` is moved / commanded - 1. A gauge reads -dir b / 2, so a positive backlash
/// makes the forward mean the smaller: ISO 230-2's mean B is -b. The sds take the
/// residuals as independent; a drift or a screw's wave makes them too small.
BaselineFit FitBaseline(const RowTable& table, const BaselineOptions& options = {});

}  // namespace caltwin
