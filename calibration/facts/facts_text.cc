#include "calibration/facts/facts_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostShown = 8;

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

void AddLines(const std::string& title,
              const std::vector<std::string>& sentences,
              std::string* text) {
  if (sentences.empty()) return;
  *text += title + "\n";
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    if (i == kMostShown) {
      *text += fmt::format("  and {} more (--json has all)\n", sentences.size() - i);
      break;
    }
    *text += "  " + sentences[i] + ".\n";
  }
}

// A scale that people know the ratio of, which says it.
bool IsSaidByRatio(const Fact& fact, const Facts& facts) {
  return fact.id == "scale" && std::ranges::any_of(facts.all, [&](const Fact& ratio) {
           return ratio.id == "known_ratio" && ratio.axis == fact.axis &&
                  ratio.figures[0].value == fact.figures[0].value;
         });
}

}  // namespace

std::string FactsText(const Facts& facts, std::string_view told) {
  std::vector<std::string> says, next;
  for (const Fact& fact : facts.all) {
    if (!IsSaidByRatio(fact, facts)) says.push_back(fact.sentence);
  }
  const NotTheMachine& other = facts.not_the_machine;
  const bool is_a_fact = std::ranges::any_of(
      facts.all, [&](const Fact& fact) { return fact.sentence == other.sentence; });
  if (!other.reason.empty() && !is_a_fact) says.insert(says.begin(), other.sentence);
  // The headline's own, which has a capital there; two series of one axis may say the
  // same.
  const auto is_told = [&](const std::string& sentence) {
    return sentence.size() > 1 && told.find(sentence.substr(1)) != told.npos;
  };
  const bool is_one_told = std::ranges::any_of(says, is_told);
  std::erase_if(says, is_told);
  std::vector<std::string> once;
  for (std::string& sentence : says) {
    if (std::ranges::find(once, sentence) == once.end())
      once.push_back(std::move(sentence));
  }
  says = std::move(once);
  for (const Advice& advice : facts.next) next.push_back(advice.sentence);
  std::string text;
  AddLines(is_one_told ? "What the numbers also say:"
                       : "What the numbers say by themselves:",
           says,
           &text);
  AddLines("What they do not determine:", facts.cannot, &text);
  AddLines("The cheapest next measurement:", next, &text);
  return text;
}

Json FactsJson(const Facts& facts) {
  Json all = Json::array();
  for (const Fact& fact : facts.all) {
    Json one = {{"fact", fact.id}, {"axis", fact.axis}};
    if (fact.id == "cross_reversal") one["seen_in"] = fact.word;
    if (fact.id == "known_ratio") one["reading"] = fact.word;
    if (fact.id == "settings") one["what"] = fact.word;
    if (fact.id == "temperature") one["thermometer"] = fact.word;
    if (fact.id == "skew") one["leans"] = fact.word;
    if (!fact.also.empty()) one["also"] = fact.also;
    for (const FactFigure& figure : fact.figures) {
      one[figure.key] = NumberOrNull(figure.value);
      one[figure.key + "_sd"] = NumberOrNull(figure.sd);
    }
    one["rows"] = fact.rows;
    one["sigmas"] = NumberOrNull(fact.sigmas);
    one["is_answer"] = fact.is_answer;
    one["says"] = fact.sentence;
    all.push_back(std::move(one));
  }
  return all;
}

Json NotDeterminedJson(const Facts& facts) {
  Json all = Json::array();
  for (std::size_t i = 0; i < facts.not_determined.size(); ++i) {
    all.push_back({{"what", facts.not_determined[i]}, {"says", facts.cannot[i]}});
  }
  return all;
}

Json NotTheMachineJson(const Facts& facts) {
  if (facts.not_the_machine.reason.empty()) return nullptr;
  return {{"reason", facts.not_the_machine.reason},
          {"says", facts.not_the_machine.sentence}};
}

Json NextMeasurementJson(const Facts& facts) {
  Json all = Json::array();
  for (const Advice& advice : facts.next) {
    all.push_back({{"instrument", advice.instrument}, {"says", advice.sentence}});
  }
  return all;
}

}  // namespace caltwin
