#include "calibration/diagnosis/diagnosis_json.h"

#include <cmath>

#include "calibration/diagnosis/unseen_rows.h"
#include "calibration/facts/facts_text.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json PartsJson(const std::vector<TablePart>& parts) {
  Json json = Json::array();
  for (const TablePart& part : parts) {
    json.push_back({{"name", part.name},
                    {"along", part.along},
                    {"size_um", part.size_um},
                    {"sd_um", NumberOrNull(part.sd_um)},
                    {"period", part.period > 0 ? Json(part.period) : Json(nullptr)}});
  }
  return json;
}

Json FindingJson(const Finding& finding, const GainFigures& gain) {
  Json candidates = Json::array();
  for (const FindingCandidate& candidate : finding.candidates) {
    candidates.push_back({{"cause", candidate.cause},
                          {"axis", candidate.axis},
                          {"probability", candidate.probability},
                          {"structural", candidate.structural}});
  }
  Json parameters = Json::array();
  for (const FindingParameter& parameter : finding.parameters) {
    parameters.push_back({{"name", parameter.name},
                          {"value", parameter.value},
                          {"sd", NumberOrNull(parameter.sd)}});
  }
  Json json = {{"cause", finding.cause},
               {"axis", finding.axis},
               {"probability", finding.probability},
               {"log_odds", finding.log_odds},
               {"candidates", candidates},
               {"parameters", parameters},
               {"share", finding.share},
               {"covariates", finding.covariates},
               {"rows", finding.rows},
               {"peak_um", finding.peak_um},
               {"recommended", WhatUnseenRowsSay(finding, gain).is_recommended}};
  if (finding.map) {
    json["knots"] = {{"channel", finding.map->channel},
                     {"covariates", finding.map->covariates},
                     {"knots", finding.map->knots},
                     {"values_um", finding.map->values_um},
                     {"kernel",
                      {{"form", "line, bow, cosines"},
                       {"terms", finding.map->terms},
                       {"prior_size_um", finding.map->prior_size_um}}}};
    json["parts"] = PartsJson(finding.map->parts);
  }
  return json;
}

Json HeldOutJson(const HeldOut& held) {
  if (held.groups == 0) return nullptr;
  return {{"rmse_before_um", UmFromMm(held.before_mm)},
          {"rmse_after_um", UmFromMm(held.after_mm)},
          {"rows", held.rows},
          {"groups", held.groups}};
}

Json GainJson(const Diagnosis& diagnosis) {
  const GainFigures& gain = diagnosis.gain;
  const bool is_none = diagnosis.findings.empty();
  return {
      {"rmse_before_um", UmFromMm(gain.blocks.before_mm)},
      {"rmse_after_um", UmFromMm(gain.blocks.after_mm)},
      {"noise_floor_um", UmFromMm(gain.noise_floor_mm)},
      {"noise_floor_from", gain.floor_from_replicates ? "replicates" : "richest model"},
      {"explained_fraction", is_none ? Json(nullptr) : Json(gain.explained_fraction)},
      {"held_out", true},
      {"runs_left_out", HeldOutJson(gain.runs)},
      {"positions_left_out", HeldOutJson(gain.positions)},
      {"ends_left_out", HeldOutJson(gain.ends)}};
}

}  // namespace

Json ToJson(const Diagnosis& diagnosis,
            const std::string& extended_model,
            const Provenance& provenance) {
  Json findings = Json::array(), absorbed = Json::array(), baseline = Json::array();
  for (const Finding& finding : diagnosis.findings) {
    findings.push_back(FindingJson(finding, diagnosis.gain));
  }
  for (const Absorbed& one : diagnosis.absorbed) {
    absorbed.push_back({{"what", one.what}, {"into", one.into}});
  }
  for (const BaselineLine& line : diagnosis.baseline) {
    baseline.push_back({{"name", line.name},
                        {"unit", line.unit},
                        {"value", line.value},
                        {"sd", NumberOrNull(line.sd)},
                        {"determined", line.is_determined}});
  }
  Json evidence = Json::array();
  for (const EvidenceLine& line : diagnosis.evidence) {
    evidence.push_back({{"cause", line.cause},
                        {"axis", line.axis},
                        {"covariates", line.covariates},
                        {"log_odds", line.log_odds}});
  }
  Json next = nullptr;
  if (diagnosis.next_campaign) {
    next = {{"kind", diagnosis.next_campaign->kind},
            {"options", diagnosis.next_campaign->options},
            {"separates", diagnosis.next_campaign->separates},
            {"minutes", diagnosis.next_campaign->minutes},
            {"separation_sigma", diagnosis.next_campaign->separation_sigma}};
  }
  return {
      {"format", 1},
      {"verdict", ToString(diagnosis.verdict)},
      {"findings", findings},
      {"gain", GainJson(diagnosis)},
      {"absorbed", absorbed},
      {"next_campaign", next},
      {"outlier_rows", diagnosis.outlier_rows},
      {"baseline", baseline},
      {"facts", FactsJson(diagnosis.facts)},
      {"not_determined", NotDeterminedJson(diagnosis.facts)},
      {"not_the_machine", NotTheMachineJson(diagnosis.facts)},
      {"next_measurement", NextMeasurementJson(diagnosis.facts)},
      {"evidence", evidence},
      {"wander_um_per_sqrt_h", diagnosis.wander_um_per_sqrt_h},
      {"extended_model", extended_model.empty() ? Json(nullptr) : Json(extended_model)},
      {"remarks", diagnosis.remarks},
      {"provenance",
       {{"data_sha256", provenance.data_sha256},
        {"machine_sha256",
         provenance.machine_sha256.empty() ? Json(nullptr)
                                           : Json(provenance.machine_sha256)},
        {"version", provenance.version},
        {"seed", provenance.seed},
        {"command", provenance.command}}}};
}

}  // namespace caltwin
