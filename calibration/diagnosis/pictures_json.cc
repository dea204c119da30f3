#include "calibration/diagnosis/pictures_json.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json Numbers(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(NumberOrNull(value));
  return json;
}

Json Map(const PicturesData& data) {
  Json all = Json::array();
  for (const EvidenceCell& cell : data.evidence_map) {
    all.push_back({{"channel", cell.channel},
                   {"covariate", cell.covariate},
                   {"log_odds", cell.log_odds},
                   {"cause", cell.cause},
                   {"axis", cell.axis}});
  }
  return all;
}

Json Findings(const PicturesData& data) {
  Json all = Json::array();
  for (const FindingSeries& series : data.findings) {
    Json one = {{"cause", series.cause},
                {"axis", series.axis},
                {"channel", series.channel},
                {"covariate", series.covariate},
                {"period_mm", series.period_mm > 0 ? Json(series.period_mm) : Json()},
                {"pure_error_um", series.pure_error_um},
                {"rows", series.rows},
                {"at", Numbers(series.at)},
                {"before_um", Numbers(series.before_um)},
                {"after_um", Numbers(series.after_um)}};
    if (!series.split_by.empty()) {
      one["split_by"] = series.split_by;
      one["split_labels"] = series.split_labels;
      one["split"] = series.split;
    }
    all.push_back(std::move(one));
  }
  return all;
}

Json Contrasts(const PicturesData& data) {
  Json all = Json::array();
  for (const DirectionContrast& contrast : data.contrasts) {
    all.push_back({{"axis", contrast.axis},
                   {"sd_um", contrast.sd_um},
                   {"at_mm", Numbers(contrast.at_mm)},
                   {"before_um", Numbers(contrast.before_um)},
                   {"after_um", Numbers(contrast.after_um)}});
  }
  return all;
}

Json Frame(const Periodogram& one) {
  return {{"axis", one.axis},
          {"turn_mm", one.lead_mm},
          {"turn_of", one.is_belt ? "pulley" : "screw"},
          {"four_full_steps_mm", one.four_full_steps_mm},
          {"noise_um", one.noise_um}};
}

// The highest local maxima of what the baseline leaves.
Json Peaks(const Periodogram& one) {
  constexpr std::size_t kMost = 5;
  const auto height = [&](std::size_t i) {
    return std::isfinite(one.before_um[i]) ? one.before_um[i] : 0;
  };
  std::vector<std::size_t> peaks;
  for (std::size_t i = 1; i + 1 < one.before_um.size(); ++i) {
    const double here_um = height(i);
    if (here_um > one.noise_um && here_um > height(i - 1) && here_um >= height(i + 1)) {
      peaks.push_back(i);
    }
  }
  std::ranges::stable_sort(peaks, std::ranges::greater{}, height);
  peaks.resize(std::min(kMost, peaks.size()));
  Json all = Json::array();
  for (const std::size_t i : peaks) {
    all.push_back({{"period_mm", one.period_mm[i]},
                   {"before_um", one.before_um[i]},
                   {"after_um", NumberOrNull(one.after_um[i])}});
  }
  return all;
}

Json Fits(const PicturesData& data) {
  Json all = Json::array();
  for (const LackOfFit& fit : data.lack_of_fit) {
    all.push_back({{"campaign", fit.campaign},
                   {"rows", fit.rows},
                   {"replicate_dof", fit.replicate_dof},
                   {"pure_error_um", NumberOrNull(fit.pure_error_um)},
                   {"sigma_um", fit.sigma_um},
                   {"before_um", fit.before_um},
                   {"after_um", fit.after_um}});
  }
  return all;
}

Json Flagged(const PicturesData& data) {
  Json all = Json::array();
  for (const FlaggedRow& row : data.flagged) {
    all.push_back({{"row", row.row},
                   {"campaign", row.campaign},
                   {"cmd_mm", Numbers(row.cmd_mm)},
                   {"value_mm", row.value_mm},
                   {"left_um", NumberOrNull(row.left_um)},
                   {"sigmas", NumberOrNull(row.sigmas)},
                   {"flag", row.flag},
                   {"left_out", row.is_out}});
  }
  return all;
}

Json Both(const PicturesData& data, Json periodograms) {
  return {{"evidence_map", Map(data)},
          {"lack_of_fit", Fits(data)},
          {"direction_contrast", Contrasts(data)},
          {"periodograms", std::move(periodograms)},
          {"flagged_rows", Flagged(data)}};
}

}  // namespace

Json PicturesJson(const PicturesData& data) {
  Json periodograms = Json::array();
  for (const Periodogram& one : data.periodograms) {
    Json json = Frame(one);
    json["period_mm"] = Numbers(one.period_mm);
    json["before_um"] = Numbers(one.before_um);
    json["after_um"] = Numbers(one.after_um);
    periodograms.push_back(std::move(json));
  }
  Json all = Both(data, std::move(periodograms));
  all["findings"] = Findings(data);
  return all;
}

Json ShowJson(const PicturesData& data) {
  Json periodograms = Json::array();
  for (const Periodogram& one : data.periodograms) {
    Json json = Frame(one);
    json["peaks"] = Peaks(one);
    periodograms.push_back(std::move(json));
  }
  return Both(data, std::move(periodograms));
}

}  // namespace caltwin
