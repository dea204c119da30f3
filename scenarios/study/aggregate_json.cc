// Aggregates written down and read again, bit for bit: sums as limbs, counts as counts.

#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include "scenarios/study/aggregate.h"

namespace caltwin {
namespace {

using Json = nlohmann::json;

template <typename Read>
Read OrNone(std::optional<Read> read, const char* what) {
  if (!read) throw std::invalid_argument(what);
  return *std::move(read);
}

ExactSum SumOf(const Json& limbs) {
  return OrNone(ExactSum::OfLimbs(limbs.get<std::vector<std::int64_t>>()),
                "these limbs are no sum's");
}

std::map<std::string, std::int64_t> CountsOf(const Json& counts) {
  return counts.get<std::map<std::string, std::int64_t>>();
}

}  // namespace

Json StreamedQuantiles::ToJson() const {
  return {{"count", count_},
          {"sum", sum_.Limbs()},
          {"squares", squares_.Limbs()},
          {"parts", sketch_.Counts()}};
}

StreamedQuantiles StreamedQuantiles::OfJson(const Json& json) {
  StreamedQuantiles quantiles;
  quantiles.count_ = json.at("count").get<std::int64_t>();
  quantiles.sum_ = SumOf(json.at("sum"));
  quantiles.squares_ = SumOf(json.at("squares"));
  quantiles.sketch_ =
      OrNone(QuantileSketch::OfCounts(json.at("parts").get<QuantileSketch::Counted>()),
             "these counts are no quantiles'");
  return quantiles;
}

Json StreamedParameter::ToJson() const {
  return {{"unit", unit},
          {"is_setting", is_setting},
          {"errors", errors_.ToJson()},
          {"trials", trials_},
          {"with_sd", with_sd_},
          {"held", held_},
          {"variances", variances_.Limbs()},
          {"squares", squares_.Limbs()},
          {"with_u", with_u_},
          {"u2", u2_.Limbs()},
          {"u4", u4_.Limbs()},
          {"u4_per_dof", u4_per_dof_.Limbs()}};
}

StreamedParameter StreamedParameter::OfJson(const Json& json) {
  StreamedParameter parameter;
  parameter.unit = json.at("unit").get<std::string>();
  parameter.is_setting = json.at("is_setting").get<bool>();
  parameter.errors_ = StreamedQuantiles::OfJson(json.at("errors"));
  parameter.trials_ = json.at("trials").get<std::int64_t>();
  parameter.with_sd_ = json.at("with_sd").get<std::int64_t>();
  parameter.held_ = json.at("held").get<std::int64_t>();
  parameter.variances_ = SumOf(json.at("variances"));
  parameter.squares_ = SumOf(json.at("squares"));
  parameter.with_u_ = json.at("with_u").get<std::int64_t>();
  parameter.u2_ = SumOf(json.at("u2"));
  parameter.u4_ = SumOf(json.at("u4"));
  parameter.u4_per_dof_ = SumOf(json.at("u4_per_dof"));
  return parameter;
}

Json Worst::ToJson() const {
  Json json = Json::array();
  for (const auto& [minus_value, trial] : worst_) {
    json.push_back({{"value", -minus_value}, {"trial", trial}});
  }
  return json;
}

Worst Worst::OfJson(const Json& json) {
  Worst worst;
  for (const Json& one : json) {
    worst.Add(one.at("value").get<double>(), one.at("trial").get<std::int64_t>());
  }
  return worst;
}

Json Aggregate::ToJson() const {
  Json parameters = Json::array();
  for (const Parameter& parameter : parameters_) {
    parameters.push_back({{"name", parameter.name},
                          {"first_trial", parameter.first.first},
                          {"position", parameter.first.second},
                          {"values", parameter.values.ToJson()}});
  }
  return {{"is_of_plan", is_of_plan_},
          {"status", status_},
          {"causes", causes_},
          {"machine_time_s", machine_time_s_.ToJson()},
          {"touches", touches_.ToJson()},
          {"position_error_before_mm", before_mm_.ToJson()},
          {"position_error_after_mm", after_mm_.ToJson()},
          {"parameters", parameters},
          {"worst", worst_.ToJson()}};
}

Aggregate Aggregate::OfJson(const Json& json) {
  Aggregate aggregate(json.at("is_of_plan").get<bool>());
  aggregate.status_ = CountsOf(json.at("status"));
  aggregate.causes_ = CountsOf(json.at("causes"));
  aggregate.machine_time_s_ = StreamedQuantiles::OfJson(json.at("machine_time_s"));
  aggregate.touches_ = StreamedQuantiles::OfJson(json.at("touches"));
  aggregate.before_mm_ = StreamedQuantiles::OfJson(json.at("position_error_before_mm"));
  aggregate.after_mm_ = StreamedQuantiles::OfJson(json.at("position_error_after_mm"));
  for (const Json& parameter : json.at("parameters")) {
    aggregate.parameters_.push_back(
        {.name = parameter.at("name").get<std::string>(),
         .first = {parameter.at("first_trial").get<std::int64_t>(),
                   parameter.at("position").get<std::size_t>()},
         .values = StreamedParameter::OfJson(parameter.at("values"))});
  }
  aggregate.worst_ = Worst::OfJson(json.at("worst"));
  return aggregate;
}

}  // namespace caltwin
