// The sealed truth of a case. Only the scorer opens it.

#include <nlohmann/json.hpp>

#include "tests/blind/case.h"

namespace blind {
namespace {

nlohmann::json HiddenJson(const HiddenTruth& hidden, const Cause& cause) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const auto& parameter : hidden.defect.parameters) {
    const double factor = parameter.grows ? hidden.defect.size : 1;
    parameters.push_back(
        {{"name", parameter.name}, {"value", parameter.value * factor}});
  }
  return {{"cause", hidden.defect.cause},
          {"axis", hidden.defect.axis},
          {"parameters", parameters},
          {"peak_sigma", hidden.peak_sigma},
          {"sum_squares", hidden.sum_squares},
          {"separation", hidden.separation},
          {"acceptable", cause.acceptable},
          {"covariates", cause.covariates}};
}

nlohmann::json BaselineJson(const Case& made) {
  nlohmann::json baseline;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    baseline["scale." + axis] = made.truth.scale[i] * 1e6;
    baseline["backlash." + axis] = made.truth.gap_mm[i];
    baseline["probe_pretravel." + axis] = made.truth.pretravel_mm[i];
  }
  baseline["bed_plane.slope_x"] = made.truth.bed_slope_x;
  baseline["bed_plane.slope_y"] = made.truth.bed_slope_y;
  return baseline;
}

}  // namespace

std::string TruthJson(const Case& made) {
  nlohmann::json truth = {{"format", 1},
                          {"kind", made.request.kind},
                          {"seed", made.request.seed},
                          {"clean", made.request.clean},
                          {"physics", made.request.physics},
                          {"rows", made.readings.size()},
                          {"baseline", BaselineJson(made)}};
  truth["causes"] = nlohmann::json::array();
  for (const HiddenTruth& hidden : made.hidden) {
    truth["causes"].push_back(HiddenJson(hidden, *FindCause(hidden.defect.cause)));
  }
  for (const Campaign& campaign : made.plan.campaigns) {
    truth["campaigns"].push_back(campaign.name);
  }
  truth["outlier_rows"] = nlohmann::json::array();
  for (std::size_t i = 0; i < made.readings.size(); ++i) {
    if (made.readings[i].is_outlier) truth["outlier_rows"].push_back(i + 1);
  }
  const Blemishes& blemishes = made.blemishes;
  truth["blemishes"] = {{"sigma_factor", blemishes.sigma_factor},
                        {"states_sigma", blemishes.states_sigma},
                        {"wander_um_per_sqrt_h", blemishes.wander_um_per_sqrt_h},
                        {"clutter_sigma", blemishes.clutter_sigma},
                        {"logs_commanded_travel", blemishes.logs_commanded_travel},
                        {"missing", blemishes.missing}};
  return truth.dump(2) + "\n";
}

}  // namespace blind
