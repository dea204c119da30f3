#include "scenarios/study/half_done.h"

#include <stdexcept>

#include <nlohmann/json.hpp>

namespace caltwin {

void DoneIndices::Add(std::int64_t index) {
  if (index < before_) return;
  beyond_.insert(index);
  while (!beyond_.empty() && *beyond_.begin() == before_) {
    beyond_.erase(beyond_.begin());
    ++before_;
  }
}

bool DoneIndices::Has(std::int64_t index) const {
  return index < before_ || beyond_.contains(index);
}

std::int64_t DoneIndices::count() const {
  return before_ + static_cast<std::int64_t>(beyond_.size());
}

nlohmann::json DoneIndices::ToJson() const {
  return {{"before", before_}, {"beyond", beyond_}};
}

DoneIndices DoneIndices::OfJson(const nlohmann::json& json) {
  DoneIndices done;
  done.before_ = json.at("before").get<std::int64_t>();
  if (done.before_ < 0) throw std::invalid_argument("no count");
  for (const auto& index : json.at("beyond")) done.Add(index.get<std::int64_t>());
  return done;
}

std::string HalfDone::Text() const {
  nlohmann::json cases = nlohmann::json::array();
  for (const Aggregate& one : aggregates) cases.push_back(one.ToJson());
  return nlohmann::json{{"done", done.ToJson()}, {"cases", cases}}.dump();
}

HalfDone HalfDone::OfText(const std::string& text) {
  const auto json = nlohmann::json::parse(text);
  HalfDone half{.done = DoneIndices::OfJson(json.at("done"))};
  for (const auto& one : json.at("cases")) {
    half.aggregates.push_back(Aggregate::OfJson(one));
  }
  return half;
}

}  // namespace caltwin
